//! The sensor and the method of `nephroid render` and `nephroid merge`.

use super::args::{MergeArgs, RenderArgs, SettingArgs};
use crate::method::Method;
use crate::method::wanted::{Chosen, Wanted};
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
    let chosen = chosen(&wanted, &args.settings, scene)?;
    Ok((chosen.sensor, chosen.method, chosen.notice))
}

/// The sensor, and the method that the shards were made by.
///
/// # Errors
///
/// As [`choose`].
pub(super) fn choose_merged(
    args: &MergeArgs,
    method: &str,
    scene: &Scene,
) -> anyhow::Result<(Sensor, Method)> {
    let given = args.settings.and(&args.set)?;
    let wanted = Wanted {
        sensor: args.sensor.as_deref(),
        method: Some(method),
        given: &given,
        is_shard: true,
        filter: args.filter.wanted(),
    };
    let chosen = chosen(&wanted, &args.settings, scene)?;
    Ok((chosen.sensor, chosen.method))
}

fn chosen(wanted: &Wanted, settings: &SettingArgs, scene: &Scene) -> anyhow::Result<Chosen> {
    let chosen = wanted.choose(scene, &|key| settings.typed(key));
    Ok(chosen.map_err(|error| match error {
        // A method's name is no setting, even if it is spelled like one.
        Error::Setting(SettingError::Unknown { ref what, .. }) if what == "method" => error,
        Error::Setting(error) => settings.retold(error).into(),
        error => error,
    })?)
}
