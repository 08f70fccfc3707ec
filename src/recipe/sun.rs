//! Where the sun stands: by its angles, or by a date, a time and a latitude.

use super::node::{Node, Value};
use super::reader::{Reader, wrong};
use super::source::{Origin, RecipeError};

/// The range of the sun's elevation, degrees.
const ELEVATION_DEG: core::ops::RangeInclusive<f64> = 10.0..=90.0;

/// `light.sun`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Sun {
    /// By its angles.
    Angles {
        /// Elevation above the horizon, degrees, 10..90.
        elevation_deg: f64,
        /// Azimuth clockwise from north, degrees, -360..360.
        azimuth_deg: f64,
    },
    /// Where it stands over a place of the Earth; 10 degrees high or more.
    Dated {
        /// Day.
        date: Date,
        /// Minutes after the midnight before, by a sundial: at 720 the sun is in the meridian.
        solar_minutes: u32,
        /// North of the equator, degrees, -90..90.
        latitude_deg: f64,
    },
}

/// A day of the Gregorian calendar, 1900..2100.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Date {
    year: u32,
    month: u32,
    day: u32,
}

impl Sun {
    /// Elevation above the horizon and azimuth clockwise from north (0..360 where it follows from a date), degrees.
    pub fn angles_deg(&self) -> [f64; 2] {
        match *self {
            Self::Angles { elevation_deg, azimuth_deg } => [elevation_deg, azimuth_deg],
            Self::Dated { date, solar_minutes, latitude_deg } => over(date, solar_minutes, latitude_deg),
        }
    }

    /// The table as text.
    pub(super) fn text(&self) -> String {
        match self {
            Self::Angles { elevation_deg, azimuth_deg } => {
                format!("{{ elevation_deg = {elevation_deg:?}, azimuth_deg = {azimuth_deg:?} }}")
            }
            Self::Dated { date: Date { year, month, day }, solar_minutes, latitude_deg } => {
                let (hour, minute) = (solar_minutes / 60, solar_minutes % 60);
                format!(
                    "{{ date = \"{year:04}-{month:02}-{day:02}\", local_solar_time = \"{hour:02}:{minute:02}\", \
                     latitude_deg = {latitude_deg:?} }}"
                )
            }
        }
    }
}

impl Date {
    const YEARS: core::ops::RangeInclusive<u32> = 1900..=2100;

    /// A day of the calendar; none where there is no such day.
    fn new(year: u32, month: u32, day: u32) -> Option<Self> {
        let leap = year.is_multiple_of(4) && (!year.is_multiple_of(100) || year.is_multiple_of(400));
        let days = match month {
            2 => 28 + u32::from(leap),
            4 | 6 | 9 | 11 => 30,
            1..=12 => 31,
            _ => return None,
        };
        (Self::YEARS.contains(&year) && (1..=days).contains(&day)).then_some(Self { year, month, day })
    }

    /// Days from noon of 1 January 2000 to the midnight that begins this day (Meeus 1998, equation 7.1).
    fn days_since_2000(self) -> f64 {
        let (year, month) = if self.month > 2 { (self.year, self.month) } else { (self.year - 1, self.month + 12) };
        let century = year / 100;
        let whole = libm::floor;
        let julian =
            whole(365.25 * f64::from(year + 4716)) + whole(30.6001 * f64::from(month + 1)) + f64::from(self.day) + 2.0
                - f64::from(century)
                + f64::from(century / 4)
                - 1524.5;
        julian - 2_451_545.0
    }
}

/// Declination of the sun, radians: Meeus 1998, chapter 25, low accuracy (0.01 degrees).
fn declination_rad(days_since_2000: f64) -> f64 {
    let t = days_since_2000 / 36_525.0;
    let mean_longitude = 280.466_46 + t * (36_000.769_83 + t * 0.000_303_2);
    let anomaly = (357.529_11 + t * (35_999.050_29 - t * 0.000_153_7)).to_radians();
    let centre = (1.914_602 - t * (0.004_817 + t * 0.000_014)) * libm::sin(anomaly)
        + (0.019_993 - t * 0.000_101) * libm::sin(2.0 * anomaly)
        + 0.000_289 * libm::sin(3.0 * anomaly);
    let node = (125.04 - 1934.136 * t).to_radians();
    let longitude = (mean_longitude + centre - 0.005_69 - 0.004_78 * libm::sin(node)).to_radians();
    let tilt = (23.439_291 - 0.013_004_2 * t + 0.002_56 * libm::cos(node)).to_radians();
    libm::asin(libm::sin(tilt) * libm::sin(longitude))
}

/// Elevation and azimuth (Meeus 1998, equations 13.5 and 13.6), degrees. A recipe names no longitude: the day's
/// declination is that of this hour at Greenwich, wrong by 0.2 degrees at most on the other side of the Earth.
fn over(date: Date, solar_minutes: u32, latitude_deg: f64) -> [f64; 2] {
    let days = f64::from(solar_minutes) / 1440.0;
    let (sin_d, cos_d) = libm::sincos(declination_rad(date.days_since_2000() + days));
    let (sin_h, cos_h) = libm::sincos((days - 0.5) * core::f64::consts::TAU);
    let (sin_l, cos_l) = libm::sincos(latitude_deg.to_radians());
    let up = sin_l * sin_d + cos_l * cos_d * cos_h;
    // Towards north and east.
    let (north, east) = (cos_l * sin_d - sin_l * cos_d * cos_h, -cos_d * sin_h);
    let azimuth_deg = libm::atan2(east, north).to_degrees();
    [libm::asin(up.clamp(-1.0, 1.0)).to_degrees(), if azimuth_deg < 0.0 { azimuth_deg + 360.0 } else { azimuth_deg }]
}

/// Reads `light.sun`.
pub(super) fn sun(mut table: Reader) -> Result<Sun, RecipeError> {
    let elevation = table.number("elevation_deg", ELEVATION_DEG)?;
    let azimuth = table.number("azimuth_deg", -360.0..=360.0)?;
    let date = dated(&mut table, "date", "a day such as \"2024-06-21\", in 1900 to 2100", |text| {
        let [year, month, day] = numbers(text, '-')?;
        Date::new(year, month, day)
    })?;
    let time = dated(&mut table, "local_solar_time", "a time by the sun such as \"10:30\"", |text| {
        let [hour, minute] = numbers(text.strip_suffix(":00").filter(|t| t.contains(':')).unwrap_or(text), ':')?;
        (hour < 24 && minute < 60).then_some(hour * 60 + minute)
    })?;
    let latitude = table.number("latitude_deg", -90.0..=90.0)?;
    let angle = elevation.as_ref().or(azimuth.as_ref()).map(|(_, origin)| origin);
    if let (Some(origin), true) = (angle, date.is_some() || time.is_some() || latitude.is_some()) {
        let [angles, date] = ["elevation_deg", "date"].map(|key| table.name(key));
        return Err(origin.error(format!(
            "`{angles}` and azimuth say where the sun stands, and so do `{date}`, time and latitude: keep either"
        )));
    }
    let sun = match (date, time, latitude) {
        (None, None, None) => Sun::Angles {
            elevation_deg: elevation.map_or(42.0, |(x, _)| x),
            azimuth_deg: azimuth.map_or(145.0, |(x, _)| x),
        },
        (Some((date, origin)), Some((solar_minutes, _)), Some((latitude_deg, _))) => {
            let sun = Sun::Dated { date, solar_minutes, latitude_deg };
            let [elevation_deg, _] = sun.angles_deg();
            if !ELEVATION_DEG.contains(&elevation_deg) {
                let name = table.name("date");
                return Err(origin.error(format!(
                    "at `{name}`, time and latitude the sun is {elevation_deg:.1} degrees high, but must be 10 to 90"
                )));
            }
            sun
        }
        (None, ..) => return Err(table.missing("date")),
        (_, None, _) => return Err(table.missing("local_solar_time")),
        (.., None) => return Err(table.missing("latitude_deg")),
    };
    table.finish()?;
    Ok(sun)
}

/// A value that is written as text or as TOML's own date.
fn dated<T>(
    table: &mut Reader,
    key: &'static str,
    expected: &str,
    parse: impl Fn(&str) -> Option<T>,
) -> Result<Option<(T, Origin)>, RecipeError> {
    let name = table.name(key);
    let Some(node) = table.take(key) else { return Ok(None) };
    let parsed = match &node {
        Node { value: Value::Text(text) | Value::DateTime(text), .. } => parse(text),
        _ => None,
    };
    match parsed {
        Some(value) => Ok(Some((value, node.origin))),
        None => Err(wrong(&name, &node, expected)),
    }
}

/// Numbers of digits alone between separators.
fn numbers<const N: usize>(text: &str, separator: char) -> Option<[u32; N]> {
    let mut found = [0; N];
    let mut parts = text.split(separator);
    for number in &mut found {
        let part = parts.next().filter(|p| (1..=4).contains(&p.len()) && p.bytes().all(|b| b.is_ascii_digit()))?;
        *number = part.parse().ok()?;
    }
    parts.next().is_none().then_some(found)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at(date: [u32; 3], time: u32, latitude_deg: f64) -> [f64; 2] {
        let [year, month, day] = date;
        let date = Date::new(year, month, day).expect("a day");
        Sun::Dated { date, solar_minutes: time, latitude_deg }.angles_deg()
    }

    /// Toronto at 10:30: what a sun-synchronous imager has.
    #[test]
    fn class_values_of_an_overpass() {
        for (date, elevation) in
            [([2024, 6, 21], 62.0), ([2024, 3, 20], 42.0), ([2023, 9, 23], 42.0), ([2024, 12, 21], 20.0)]
        {
            let [found, azimuth] = at(date, 630, 43.7);
            assert!((found - elevation).abs() < 0.8, "{date:?}: {found} against {elevation}");
            assert!((120.0..=165.0).contains(&azimuth), "{date:?}: {azimuth}");
        }
    }

    /// Meeus 1998, example 25.a: 13 October 1992 at 0 h, apparent declination -7.785 degrees.
    #[test]
    fn declination_of_a_published_example() {
        let days = Date::new(1992, 10, 13).expect("a day").days_since_2000();
        assert_eq!(days, 2_448_908.5 - 2_451_545.0);
        let found = declination_rad(days).to_degrees();
        assert!((found + 7.785).abs() < 0.001, "{found}");
    }

    #[test]
    fn noon_is_in_the_meridian_and_mornings_mirror_evenings() {
        let [noon, south] = at([2024, 6, 21], 720, 43.7);
        assert!((noon - (90.0 - 43.7 + 23.44)).abs() < 0.01 && (south - 180.0).abs() < 1e-9, "{noon} {south}");
        // South of the equator the sun culminates in the north.
        let [_, north] = at([2024, 6, 21], 720, -33.0);
        assert!(!(1e-6..360.0 - 1e-6).contains(&north), "{north}");
        let ([a, east], [b, west]) = (at([2024, 3, 20], 600, 43.7), at([2024, 3, 20], 840, 43.7));
        assert!((a - b).abs() < 0.1 && (east + west - 360.0).abs() < 0.1, "{a} {b} {east} {west}");
    }

    #[test]
    fn days_that_are_none() {
        for [year, month, day] in
            [[2023, 2, 29], [2024, 13, 1], [2024, 4, 31], [2024, 0, 1], [1899, 12, 31], [2024, 1, 0]]
        {
            assert!(Date::new(year, month, day).is_none());
        }
        assert!(Date::new(2000, 2, 29).is_some() && Date::new(1900, 2, 29).is_none());
    }
}
