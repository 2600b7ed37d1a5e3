//! The position of the sun, and its radiance through the atmosphere.

use gi_core::math::Rgb;
use glam::DVec3;

/// Angular radius of the sun seen from the earth, radians (Mitsuba's 0.5358 degrees across).
pub(crate) const ANGULAR_RADIUS: f32 = 0.004_675_7;

/// A time and a place.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Moment {
    pub(crate) year: i64,
    pub(crate) month: i64,
    pub(crate) day: i64,
    /// Hours of local time, with minutes and seconds as fractions.
    pub(crate) hours: f64,
    /// Hours by which local time is ahead of universal time.
    pub(crate) timezone: f64,
    /// Degrees north.
    pub(crate) latitude: f64,
    /// Degrees east.
    pub(crate) longitude: f64,
}

/// Direction toward the sun as (south, west, up) \[BlancoMuriel01\].
pub(crate) fn direction(m: &Moment) -> DVec3 {
    let hours = m.hours - m.timezone;
    let days = days_since_2000(m.year, m.month, m.day) + hours / 24.0;
    // Ecliptic coordinates.
    let node = 2.1429 - 0.001_039_459_4 * days;
    let mean_longitude = 4.895_063_0 + 0.017_202_791_698 * days;
    let anomaly = 6.240_060_0 + 0.017_201_969_9 * days;
    let longitude =
        mean_longitude + 0.033_416_07 * anomaly.sin() + 0.000_348_94 * (2.0 * anomaly).sin()
            - 0.000_113_4
            - 0.000_020_3 * node.sin();
    let obliquity = 0.409_092_8 - 6.2140e-9 * days + 0.000_039_6 * node.cos();
    // Celestial coordinates.
    let ascension = (obliquity.cos() * longitude.sin()).atan2(longitude.cos());
    let declination = (obliquity.sin() * longitude.sin()).asin();
    // Local coordinates.
    let sidereal = 6.697_424_324_2 + 0.065_709_828_3 * days + hours;
    let hour_angle = (sidereal * 15.0 + m.longitude).to_radians() - ascension;
    let (sin_lat, cos_lat) = m.latitude.to_radians().sin_cos();
    let cos_zenith = cos_lat * hour_angle.cos() * declination.cos() + declination.sin() * sin_lat;
    let azimuth =
        (-hour_angle.sin()).atan2(declination.tan() * cos_lat - sin_lat * hour_angle.cos());
    const PARALLAX: f64 = 6371.01 / 149_597_890.0; // earth's radius / distance of the sun
    let zenith = cos_zenith.acos();
    let (sin, cos) = (zenith + PARALLAX * zenith.sin()).sin_cos();
    DVec3::new(-azimuth.cos() * sin, -azimuth.sin() * sin, cos)
}

/// Days from noon of 1 January 2000 to the preceding midnight of a day in the Gregorian calendar \[Fliegel68\].
fn days_since_2000(year: i64, month: i64, day: i64) -> f64 {
    let a = (month - 14) / 12;
    let julian = (1461 * (year + 4800 + a)) / 4 + (367 * (month - 2 - 12 * a)) / 12
        - (3 * ((year + 4900 + a) / 100)) / 4
        + day
        - 32_075;
    julian as f64 - 0.5 - 2_451_545.0
}

/// Radiance of the sun outside the atmosphere, from the fit below; linear Rec. 709, W / (m^2 sr nm).
const OUTSIDE: [f32; 3] = [24388.0, 22190.0, 20857.0];

/// Vertical optical depth of the whole atmosphere, for turbidity 1 to 10.
///
/// Fitted to the solar radiance of \[Hosek13\] as Mitsuba 3.9.1 computes it in RGB. Above 10 degrees of elevation, the
/// error is at most 1.1 % for turbidities up to 6, and 3.5 % up to 10. Within a few degrees of the horizon, one number
/// per channel no longer describes the absorption, and only the order of magnitude is right.
const DEPTH: [[f32; 3]; 10] = [
    [0.0685, 0.1385, 0.3127],
    [0.0779, 0.1488, 0.3225],
    [0.0934, 0.1659, 0.3387],
    [0.1190, 0.1942, 0.3654],
    [0.1467, 0.2246, 0.3943],
    [0.1665, 0.2465, 0.4150],
    [0.1993, 0.2826, 0.4492],
    [0.2533, 0.3421, 0.5056],
    [0.3424, 0.4401, 0.5985],
    [0.4891, 0.6017, 0.7515],
];

/// Radiance of the sun's disc through the atmosphere, linear Rec. 709, W / (m^2 sr nm): Beer's law.
///
/// `elevation` in radians above the horizon, `turbidity` from 1 to 10.
pub(crate) fn radiance(elevation: f32, turbidity: f32) -> Rgb {
    let degrees = elevation.to_degrees().clamp(0.0, 90.0);
    // Air mass: the length of the path through the air, relative to the vertical [Kasten89].
    let mass = 1.0 / (elevation.max(0.0).sin() + 0.505_72 * (degrees + 6.079_95).powf(-1.6364));
    let t = (turbidity - 1.0).clamp(0.0, 8.999);
    let (below, above) = (DEPTH[t as usize], DEPTH[t as usize + 1]);
    Rgb::from(std::array::from_fn(|k| {
        let depth = below[k] + (above[k] - below[k]) * t.fract();
        OUTSIDE[k] * (-mass * depth).exp()
    }))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_sun_stands_south_at_noon_and_in_the_west_later() {
        // Tokyo, 10 July 2010. Reference values from Mitsuba 3.9.1, which uses the same algorithm.
        let tokyo = |hours| Moment {
            year: 2010,
            month: 7,
            day: 10,
            hours,
            timezone: 9.0,
            latitude: 35.6894,
            longitude: 139.6917,
        };
        let expected = [
            (9.0, [0.095_695, -0.614_786, 0.782_867]),
            (12.0, [0.231_117, 0.054_389, 0.971_405]),
            (15.0, [0.051_385, 0.691_748, 0.720_308]),
            (18.0, [-0.338_579, 0.924_233, 0.176_514]),
        ];
        for (hours, want) in expected {
            let got = direction(&tokyo(hours));
            // Mitsuba computes in single precision, in which the days since 2000 have steps of half a minute.
            assert!((got - DVec3::from(want)).length() < 5e-3, "{hours}: {got} {want:?}");
        }
    }

    #[test]
    fn the_sun_has_mitsubas_radiance() {
        // Mitsuba 3.9.1, `sunsky` with sky_scale 0: (turbidity, degrees of elevation, mean over the disc).
        let expected = [
            (2.0, 35.0, [21306.2, 17130.5, 11905.4]),
            (3.0, 10.0, [14483.4, 8782.6, 3138.8]),
            (3.0, 60.0, [21824.1, 18274.9, 14074.2]),
            (6.5, 35.0, [17774.4, 14022.3, 9844.7]),
        ];
        for (turbidity, degrees, want) in expected {
            let got = radiance(f32::to_radians(degrees), turbidity).to_array();
            for k in 0..3 {
                assert!((got[k] / want[k] - 1.0).abs() < 0.015, "{turbidity} {degrees}: {got:?}");
            }
        }
    }

    #[test]
    fn a_low_sun_is_dim_and_red() {
        let (high, low) = (radiance(1.2, 3.0), radiance(0.1, 3.0));
        assert!(low.max() < high.max() && low.b / low.r < 0.5 * high.b / high.r);
        assert!(radiance(0.5, 6.0).luminance() < radiance(0.5, 2.0).luminance());
        assert!(radiance(0.0, 10.0).is_finite());
    }
}
