//! Axis: its range, its scale, its ticks.

/// Scale of an axis or a colour bar.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum AxisScale {
    /// Equal differences take equal lengths.
    Linear,
    /// Equal ratios take equal lengths; values are above 0.
    Log,
}

/// Axis from `low` to `high`.
#[derive(Clone, Debug, PartialEq)]
pub struct Axis {
    /// Name and unit.
    pub label: String,
    /// Value at the left or lower end.
    pub low: f64,
    /// Value at the right or upper end.
    pub high: f64,
    /// Scale between the ends.
    pub scale: AxisScale,
}

/// Tick of an axis.
#[derive(Clone, Debug, PartialEq)]
pub struct Tick {
    /// Value of the tick.
    pub value: f64,
    /// Label; empty for a minor tick.
    pub label: String,
}

/// Share of the data's range that stays free at each end of a fitted axis.
const MARGIN: f64 = 0.05;

impl Axis {
    /// Returns a linear axis. A range that is empty or not finite becomes one around its lower end.
    pub fn linear(label: impl Into<String>, low: f64, high: f64) -> Self {
        let low = if low.is_finite() { low } else { 0.0 };
        let sound = high.is_finite() && high != low;
        let high = if sound { high } else { low + low.abs().max(1.0) };
        Self { label: label.into(), low, high, scale: AxisScale::Linear }
    }

    /// Returns a logarithmic axis. A range that is empty, not finite or not positive becomes one that can be drawn.
    pub fn log(label: impl Into<String>, low: f64, high: f64) -> Self {
        let positive = |x: f64| x.is_finite() && x > 0.0;
        let (low, high) = match (positive(low), positive(high)) {
            (true, true) if low != high => (low, high),
            (true, _) => (low, low * 10.0),
            (false, true) => (high * 1e-3, high),
            (false, false) => (1.0, 10.0),
        };
        Self { label: label.into(), low, high, scale: AxisScale::Log }
    }

    /// Returns the axis that holds all `values` that it can, with a margin.
    pub fn fit(label: impl Into<String>, scale: AxisScale, values: impl IntoIterator<Item = f64>) -> Self {
        let can = |x: &f64| x.is_finite() && (scale == AxisScale::Linear || *x > 0.0);
        let (low, high) = values
            .into_iter()
            .filter(can)
            .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), x| (low.min(x), high.max(x)));
        match scale {
            AxisScale::Linear => {
                let room = (high - low) * MARGIN;
                Self::linear(label, low - room, high + room)
            }
            AxisScale::Log => {
                let room = (high / low).powf(MARGIN);
                Self::log(label, low / room, high * room)
            }
        }
    }

    /// Returns the position of `value` on the axis, 0 at the low end and 1 at the high one; not finite for a value that the scale cannot
    /// show.
    pub fn share(&self, value: f64) -> f64 {
        match self.scale {
            AxisScale::Linear => (value - self.low) / (self.high - self.low),
            AxisScale::Log => (value / self.low).ln() / (self.high / self.low).ln(),
        }
    }

    /// Returns the ticks from the low end to the high one, about `wanted` of them with a label.
    pub fn ticks(&self, wanted: usize) -> Vec<Tick> {
        let decades = (self.high / self.low).log10().abs();
        let ticks = match self.scale {
            AxisScale::Log if decades > 0.7 => self.log_ticks(decades, wanted),
            _ => self.linear_ticks(wanted),
        };
        ticks.into_iter().filter(|tick| self.holds(tick)).collect()
    }

    /// Returns the ticks of several decades, with labels between decades where else fewer than two were on the axis.
    fn log_ticks(&self, decades: f64, wanted: usize) -> Vec<Tick> {
        let fine = decades < 0.5 * wanted as f64;
        let ticks = log_ticks(self.low, self.high, decades, wanted, fine);
        let labelled = ticks.iter().filter(|tick| !tick.label.is_empty() && self.holds(tick)).count();
        if labelled >= 2 { ticks } else { log_ticks(self.low, self.high, decades, wanted, true) }
    }

    /// Returns linear ticks, more than are `wanted` where these are no scale.
    fn linear_ticks(&self, wanted: usize) -> Vec<Tick> {
        /// Fewest ticks that make a scale, and largest multiple of the wanted number that is tried.
        const FEWEST: usize = 2;
        const MOST: usize = 4;
        let ticks = |wanted: usize| -> Vec<Tick> {
            linear_ticks(self.low, self.high, wanted).into_iter().filter(|tick| self.holds(tick)).collect()
        };
        let tried = (wanted..=MOST * wanted.max(1)).map(ticks);
        tried.into_iter().find(|ticks| ticks.len() >= FEWEST).unwrap_or_else(|| ticks(wanted))
    }

    /// Returns true if `tick` is on the axis.
    fn holds(&self, tick: &Tick) -> bool {
        /// Rounding of a share of the axis.
        const ROUNDING: f64 = 1e-9;
        (-ROUNDING..=1.0 + ROUNDING).contains(&self.share(tick.value))
    }
}

/// Returns multiples of 1, 2 or 5 times a power of ten.
fn linear_ticks(low: f64, high: f64, wanted: usize) -> Vec<Tick> {
    let (low, high) = (low.min(high), low.max(high));
    let rough = (high - low) / wanted.max(1) as f64;
    let power = 10f64.powf(rough.log10().floor());
    let step = power * [1.0, 2.0, 5.0, 10.0].into_iter().find(|m| m * power >= rough * 0.999).unwrap_or(10.0);
    let (first, last) = ((low / step - 1e-9).ceil(), (high / step + 1e-9).floor());
    let count = if (last - first).is_finite() { (last - first) as i64 } else { 0 };
    (0..=count.min(1000))
        .map(|i| {
            // Multiples of a step below 1 are best divided: 3·0.1 is not 0.3.
            let n = first + i as f64;
            let value = if step < 1.0 { n / (1.0 / step).round() } else { n * step };
            let value = if step < 1e-12 { n * step } else { value };
            Tick { value, label: number(value, step) }
        })
        .collect()
}

/// Returns decades, or every few of them, with unlabelled ticks between; with labels at 2 and 5 if `fine`.
fn log_ticks(low: f64, high: f64, decades: f64, wanted: usize, fine: bool) -> Vec<Tick> {
    let (low, high) = (low.min(high), low.max(high));
    let (first, last) = (low.log10().floor() as i32, high.log10().ceil() as i32);
    let every = (decades / wanted.max(1) as f64).ceil().max(1.0) as i32;
    (first..=last)
        .flat_map(|exponent| {
            (1..10).map(move |digit| {
                let value = f64::from(digit) * 10f64.powi(exponent);
                let labelled =
                    exponent.rem_euclid(every) == 0 && (digit == 1 || fine && [2, 5].contains(&digit));
                Tick { value, label: if labelled { number(value, value) } else { String::new() } }
            })
        })
        .filter(|tick| every == 1 || !tick.label.is_empty())
        .collect()
}

/// Writes `value` to the precision of `step`: plain if that is short, otherwise as 2·10⁻⁷.
pub fn number(value: f64, step: f64) -> String {
    /// Range in which a plain number is short.
    const PLAIN: (f64, f64) = (9e-4, 1e6);
    let minus = |text: String| text.replace('-', "−");
    let size = value.abs();
    if size < step * 1e-6 {
        return "0".to_owned();
    }
    let smallest = step.abs().min(size);
    if smallest >= PLAIN.0 && size < PLAIN.1 {
        let decimals = (-(step.abs().log10() + 1e-9).floor()).max(0.0) as usize;
        return minus(format!("{value:.decimals$}"));
    }
    let exponent = (size.log10() + 1e-9).floor();
    let decimals = (exponent - (step.abs().log10() + 1e-9).floor()).clamp(0.0, 6.0) as usize;
    let mantissa = format!("{:.decimals$}", value / 10f64.powf(exponent));
    let power = format!("10{}", superscript(exponent as i32));
    minus(if mantissa == "1" { power } else { format!("{mantissa}·{power}") })
}

fn superscript(exponent: i32) -> String {
    const DIGITS: [char; 10] = ['⁰', '¹', '²', '³', '⁴', '⁵', '⁶', '⁷', '⁸', '⁹'];
    exponent.to_string().chars().map(|c| c.to_digit(10).map_or('⁻', |digit| DIGITS[digit as usize])).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn labels(axis: &Axis, wanted: usize) -> Vec<String> {
        axis.ticks(wanted).into_iter().map(|t| t.label).filter(|l| !l.is_empty()).collect()
    }

    #[test]
    fn linear_ticks_are_round_numbers_within_the_range() {
        assert_eq!(labels(&Axis::linear("", 0.0, 1.0), 5), ["0", "0.2", "0.4", "0.6", "0.8", "1.0"]);
        assert_eq!(labels(&Axis::linear("", 380.0, 780.0), 4), ["400", "500", "600", "700"]);
        assert_eq!(labels(&Axis::linear("", -3.0, 4.0), 4), ["−2", "0", "2", "4"]);
        assert_eq!(labels(&Axis::linear("", 0.0, 4e-7), 2), ["0", "2·10⁻⁷", "4·10⁻⁷"]);
        assert_eq!(labels(&Axis::linear("", -9.9, 9.9), 2), ["−5", "0", "5"], "one tick is no scale");
        assert_eq!(labels(&Axis::linear("", 4.0, -3.0), 4), ["−2", "0", "2", "4"], "a falling axis");
    }

    #[test]
    fn log_ticks_are_decades_with_small_ones_between() {
        let axis = Axis::log("", 1e-5, 1e-1);
        assert_eq!(labels(&axis, 6), ["10⁻⁵", "10⁻⁴", "0.001", "0.01", "0.1"]);
        assert_eq!(axis.ticks(6).len(), 4 * 9 + 1);
        assert_eq!(labels(&Axis::log("", 1.0, 20.0), 6), ["1", "2", "5", "10", "20"]);
        assert_eq!(labels(&Axis::log("", 1e-12, 1.0), 4), ["10⁻¹²", "10⁻⁹", "10⁻⁶", "0.001", "1"]);
    }

    #[test]
    fn shares_go_from_0_to_1_and_ranges_that_cannot_be_drawn_become_some() {
        let axis = Axis::log("", 1.0, 100.0);
        assert!((axis.share(10.0) - 0.5).abs() < 1e-12 && !axis.share(-1.0).is_finite());
        for (low, high) in [(1.0, 1.0), (f64::NAN, 2.0), (0.0, f64::INFINITY), (-1.0, -1.0), (0.0, 0.0)] {
            for axis in [Axis::linear("", low, high), Axis::log("", low, high)] {
                assert!(axis.share(axis.low) == 0.0 && (axis.share(axis.high) - 1.0).abs() < 1e-12);
                assert!(!axis.ticks(5).is_empty(), "{axis:?}");
            }
        }
        let fitted = Axis::fit("", AxisScale::Log, [0.0, 1.0, f64::NAN, 100.0]);
        assert!(fitted.low < 1.0 && fitted.low > 0.5 && fitted.high > 100.0);
    }
}
