//! The meaning of `<integrator>`: the paths that a file asks for.

use super::plugin::Plugin;
use crate::mitsuba::error::LoadError;
use crate::mitsuba::syntax::{ObjectIndex, ObjectKind, Tree};
use crate::scene::Integrator;

/// The limits that an integrator sets on paths; `None` if it follows none, or follows them otherwise than
/// `path` does.
///
/// `aov` stands for the integrator inside of it. Parameters of other meaning are not looked at: methods are
/// chosen on the command line.
///
/// # Errors
///
/// If a parameter is not what Mitsuba allows.
pub fn read(tree: &Tree, integrator: ObjectIndex) -> Result<Option<Integrator>, LoadError> {
    let plugin = Plugin::new(tree, integrator);
    let max_depth = match plugin.name() {
        "aov" => {
            return match plugin.children(ObjectKind::Integrator).first() {
                Some((nested, _)) => read(tree, *nested),
                None => Ok(None),
            };
        }
        // Direct light met one surface, whatever the file says.
        "direct" => Some(2),
        "path" | "ptracer" | "volpath" | "volpathmis" => {
            let depth = plugin.float_or("max_depth", -1.0)?;
            let is_allowed = depth == -1.0 || (0.0..=f64::from(u32::MAX)).contains(&depth);
            if !is_allowed || depth.fract() != 0.0 {
                let message = format!("needs a max_depth of -1 (no limit) or more, not {depth}");
                return Err(plugin.error(message));
            }
            (depth >= 0.0).then_some(depth as u32)
        }
        _ => return Ok(None),
    };
    Ok(Some(Integrator {
        plugin: plugin.name().to_owned(),
        hide_emitters: plugin.boolean_or("hide_emitters", false)?,
        max_depth,
        rr_depth: plugin.integer_or("rr_depth", 1, Integrator::DEFAULT_RR_DEPTH)?,
    }))
}

/// Reason why an integrator makes no difference to other methods.
pub fn why_ignored(found: Option<&Integrator>) -> &'static str {
    if found.is_some() {
        "methods are chosen on the command line; of this one paths from a camera take max_depth, \
         rr_depth and hide_emitters"
    } else {
        "methods are chosen on the command line, and depth by what is asked of them"
    }
}
