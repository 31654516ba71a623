//! A day of the calendar, for what holds until a day.

use crate::error::{Error, Result, printable};
use std::fmt;

/// A day of the Gregorian calendar in UTC.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub struct Date {
    year: i64,
    month: u8,
    day: u8,
}

impl Date {
    /// A day written as `2026-11-21`.
    ///
    /// # Errors
    /// [`Error::Usage`] for anything else, also for a day that no month has.
    ///
    /// ```
    /// use amcheck::process::Date;
    /// assert!(Date::parse("2028-02-29").unwrap() < Date::parse("2028-03-01").unwrap());
    /// assert!(Date::parse("2027-02-29").is_err());
    /// ```
    pub fn parse(text: &str) -> Result<Self> {
        let refused = || Error::Usage {
            problem: format!("`{}` is no date", printable(text)),
            remedy: "write year, month and day: 2026-11-21".into(),
        };
        let shaped = text.len() == 10 && text.bytes().enumerate().all(|(i, b)| (i == 4 || i == 7) == (b == b'-'));
        let mut parts =
            text.split('-').map(|p| p.parse::<u16>().ok().filter(|_| p.bytes().all(|b| b.is_ascii_digit())));
        match (shaped, parts.next().flatten(), parts.next().flatten(), parts.next().flatten()) {
            (true, Some(year), Some(month @ 1..=12), Some(day)) if (1..=month_length(year, month)).contains(&day) => {
                Ok(Date { year: i64::from(year), month: month as u8, day: day as u8 })
            }
            _ => Err(refused()),
        }
    }

    /// The day that holds a moment, given in seconds since 1970-01-01 00:00 UTC.
    ///
    /// # Source
    /// H. Hinnant, *chrono-compatible low-level date algorithms*, 2013: days are counted in eras of 400 years that begin
    /// in March, so that the leap day is the last.
    pub fn of_unix_seconds(seconds: u64) -> Self {
        let days = (seconds / 86_400) as i64 + 719_468;
        let (era, of_era) = (days / 146_097, days % 146_097);
        let year = (of_era - of_era / 1_460 + of_era / 36_524 - of_era / 146_096) / 365;
        let of_year = of_era - (365 * year + year / 4 - year / 100);
        let shifted = (5 * of_year + 2) / 153;
        let day = of_year - (153 * shifted + 2) / 5 + 1;
        let month = if shifted < 10 { shifted + 3 } else { shifted - 9 };
        Date { year: year + 400 * era + i64::from(month <= 2), month: month as u8, day: day as u8 }
    }
}

fn month_length(year: u16, month: u16) -> u16 {
    let leap = (year.is_multiple_of(4) && !year.is_multiple_of(100)) || year.is_multiple_of(400);
    match month {
        2 if leap => 29,
        2 => 28,
        4 | 6 | 9 | 11 => 30,
        _ => 31,
    }
}

impl fmt::Display for Date {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{:04}-{:02}-{:02}", self.year, self.month, self.day)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_day_of_two_centuries_follows_the_one_before() {
        let mut expected = Date::parse("1970-01-01").unwrap();
        for day in 0..73_000u64 {
            let date = Date::of_unix_seconds(day * 86_400 + 86_399);
            assert_eq!(date, expected, "day {day}");
            assert_eq!(Date::parse(&date.to_string()).unwrap(), date);
            expected = if u16::from(date.day) < month_length(date.year as u16, u16::from(date.month)) {
                Date { day: date.day + 1, ..date }
            } else if date.month < 12 {
                Date { month: date.month + 1, day: 1, ..date }
            } else {
                Date { year: date.year + 1, month: 1, day: 1 }
            };
        }
        assert_eq!(Date::of_unix_seconds(951_782_400).to_string(), "2000-02-29");
    }

    #[test]
    fn what_is_no_date_is_refused() {
        for text in
            ["", "2026-11-31", "2026-13-01", "2026-1-01", "26-11-2100", "2026-11-2x", "+026-11-21", "2100-02-29"]
        {
            assert!(Date::parse(text).is_err(), "{text}");
        }
    }
}
