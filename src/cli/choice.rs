//! The sensor and the method of `nephroid render`.

use super::args::RenderArgs;
use crate::method::Method;
use crate::method::wanted::Wanted;
use crate::run::Error;
use crate::scene::{Scene, Sensor};
use crate::setting::SettingError;

/// The sensor and the method asked for, or those that suit the scene, with a notice if the method is not what
/// one would expect.
///
/// # Errors
///
/// For a sensor, a method or a setting that does not exist.
pub(super) fn choose(
    args: &RenderArgs,
    scene: &Scene,
) -> anyhow::Result<(Sensor, Method, Option<String>)> {
    let given = args.settings.and(&args.set)?;
    let wanted = Wanted {
        sensor: args.sensor.as_deref(),
        method: args.method.as_deref(),
        given: &given,
        is_shard: args.shard.is_some(),
        filter: args.filter.wanted(),
    };
    let chosen = wanted.choose(scene, &|key| args.settings.typed(key));
    let chosen = chosen.map_err(|error| match error {
        // A method's name is no setting, even if it is spelled like one.
        Error::Setting(SettingError::Unknown { ref what, .. }) if what == "method" => error,
        Error::Setting(error) => args.settings.retold(error).into(),
        error => error,
    })?;
    Ok((chosen.sensor, chosen.method, chosen.notice))
}
