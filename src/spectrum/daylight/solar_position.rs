//! Where the sun is at a place and a time.
//!
//! M. Blanco-Muriel, D. C. Alarcón-Padilla, T. López-Moratalla, M. Lara-Coira, "Computing the solar vector",
//! Solar Energy 70(5), 2001: within half a minute of arc from 1999 to 2015. Here all is in double precision.
//! Mitsuba 3.9.1 counts the days since 2000 in single precision, in steps of a quarter of a day: its sun is
//! off by up to an eighth of a degree.

use std::f64::consts::TAU;

use glam::DVec3;

use crate::numeric::math;

/// A place on Earth.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Place {
    /// Degrees north of the equator.
    pub latitude: f64,
    /// Degrees east of Greenwich.
    pub longitude: f64,
    /// Hours that its clocks are ahead of universal time.
    pub timezone: f64,
}

/// A date (Gregorian) and the time on the clocks of a place.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Clock {
    /// Year.
    pub year: i32,
    /// Month, from 1.
    pub month: i32,
    /// Day of the month, from 1.
    pub day: i32,
    /// Hour.
    pub hour: f64,
    /// Minute.
    pub minute: f64,
    /// Second.
    pub second: f64,
}

impl Clock {
    /// Universal time of the day \[h\], which may lie outside of 0..24.
    fn universal_hours(&self, place: &Place) -> f64 {
        self.hour - place.timezone + (self.minute + self.second / 60.0) / 60.0
    }

    /// Days since noon of 1 January 2000, universal time.
    fn days(&self, place: &Place) -> f64 {
        let [year, month, day] = [self.year, self.month, self.day].map(i64::from);
        // The day's Julian number by Fliegel and van Flandern (1968).
        let early = (month - 14) / 12;
        let number = (1461 * (year + 4800 + early)) / 4 + (367 * (month - 2 - 12 * early)) / 12
            - (3 * ((year + 4900 + early) / 100)) / 4
            + day
            - 32075;
        (number - 2_451_545) as f64 - 0.5 + self.universal_hours(place) / 24.0
    }
}

/// The direction to the sun, a unit vector. It may be below the horizon.
///
/// As in Mitsuba 3.9.1, x points south, y *west* and z up: a map of the world in these axes is its mirror
/// image.
pub fn sun_direction(clock: &Clock, place: &Place) -> DVec3 {
    let days = clock.days(place);
    let omega = 2.1429 - 0.001_039_459_4 * days;
    let mean_longitude = 4.895_063 + 0.017_202_791_698 * days;
    let anomaly = 6.240_06 + 0.017_201_969_9 * days;
    let ecliptic_longitude = mean_longitude
        + 0.033_416_07 * math::sin(anomaly)
        + 0.000_348_94 * math::sin(2.0 * anomaly)
        - 0.000_113_4
        - 0.000_020_3 * math::sin(omega);
    let obliquity = 0.409_092_8 - 6.214e-9 * days + 0.000_039_6 * math::cos(omega);

    let (sin_longitude, cos_longitude) = math::sin_cos(ecliptic_longitude);
    let right_ascension = math::atan2(math::cos(obliquity) * sin_longitude, cos_longitude);
    let sin_declination = math::sin(obliquity) * sin_longitude;
    let declination = math::asin(sin_declination);

    let sidereal_hours = 6.697_424_324_2 + 0.065_709_828_3 * days + clock.universal_hours(place);
    let local = (sidereal_hours * 15.0 + place.longitude).to_radians();
    let (sin_latitude, cos_latitude) = math::sin_cos(place.latitude.to_radians());
    let (sin_hour, cos_hour) = math::sin_cos((local - right_ascension) % TAU);

    let cos_zenith =
        cos_latitude * cos_hour * math::cos(declination) + sin_declination * sin_latitude;
    let zenith = math::acos(cos_zenith.clamp(-1.0, 1.0));
    // Azimuth from north, clockwise.
    let azimuth = math::atan2(
        -sin_hour,
        math::tan(declination) * cos_latitude - sin_latitude * cos_hour,
    );
    // The sun is seen from the ground, not from the middle of the Earth: radius by distance.
    let zenith = zenith + 6371.01 / 149_597_890.0 * math::sin(zenith);
    let (sin, cos) = math::sin_cos(zenith);
    let (east, north) = math::sin_cos(azimuth);
    DVec3::new(-north * sin, -east * sin, cos)
}

/// The angle above the horizon \[rad\] of a direction whose z points up.
///
/// By atan2: an arc sine loses half its digits at the zenith.
pub fn elevation(direction: DVec3) -> f64 {
    math::atan2(direction.z, math::hypot(direction.x, direction.y))
}
