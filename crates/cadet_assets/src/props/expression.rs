//! Arithmetic as the files of props write it: numbers, named numbers, operators, functions, and random draws.
//!
//! No library fits: those under a free license (exmex, fasteval, meval) know no draws, no branches that are evaluated
//! alone, and the platform's sine.

use cadet_base::math;
use cadet_base::rng::Stream;

/// A parsed expression.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Expression {
    Number(f64),
    Name(String),
    Not(Box<Self>),
    Negative(Box<Self>),
    Binary(Operator, Box<Self>, Box<Self>),
    Call(Function, Vec<Self>),
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Operator {
    Or,
    And,
    Equal,
    Unequal,
    Less,
    AtMost,
    More,
    AtLeast,
    Add,
    Subtract,
    Multiply,
    Divide,
    Remainder,
}

macro_rules! functions {
    ($($variant:ident $name:literal $least:literal to $most:expr;)*) => {
        /// What may be called.
        #[derive(Debug, Clone, Copy, PartialEq, Eq)]
        pub(super) enum Function {
            $($variant,)*
        }

        impl Function {
            /// The names, comma separated.
            pub(super) const NAMES: &'static [&'static str] = &[$($name),*];

            pub(super) fn from_name(name: &str) -> Option<Self> {
                match name {
                    $($name => Some(Self::$variant),)*
                    _ => None,
                }
            }

            /// The name and the least and greatest number of arguments.
            pub(super) fn signature(self) -> (&'static str, usize, usize) {
                match self {
                    $(Self::$variant => ($name, $least, $most),)*
                }
            }
        }
    };
}

functions! {
    Sin "sin" 1 to 1;
    Cos "cos" 1 to 1;
    Sqrt "sqrt" 1 to 1;
    Pow "pow" 2 to 2;
    Abs "abs" 1 to 1;
    Sign "sign" 1 to 1;
    Floor "floor" 1 to 1;
    Ceil "ceil" 1 to 1;
    Round "round" 1 to 1;
    Min "min" 2 to 9;
    Max "max" 2 to 9;
    If "if" 3 to 3;
    Choose "choose" 2 to 17;
    ByLevel "by_level" 3 to 4;
    Ramp "ramp" 5 to 41;
    Range "range" 2 to 2;
    Chance "chance" 1 to 1;
    Below "below" 1 to 1;
    Weighted "weighted" 2 to 16;
}

/// The names that expressions know, the latest last, and the stream that they draw from.
#[derive(Debug)]
pub(super) struct Scope<'a> {
    names: Vec<(&'a str, f64)>,
    pub stream: Stream,
}

impl<'a> Scope<'a> {
    pub(super) fn new(stream: Stream) -> Self {
        Self { names: Vec::new(), stream }
    }

    pub(super) fn add(&mut self, name: &'a str, value: f64) {
        self.names.push((name, value));
    }

    /// The number of names, for [`forget`](Self::forget).
    pub(super) fn mark(&self) -> usize {
        self.names.len()
    }

    /// Forgets the names that came after a mark.
    pub(super) fn forget(&mut self, mark: usize) {
        self.names.truncate(mark);
    }

    fn get(&self, name: &str) -> Result<f64, String> {
        let found = self.names.iter().rev().find(|(known, _)| *known == name);
        found.map(|(_, value)| *value).ok_or_else(|| format!("unknown name {name:?}"))
    }
}

impl Expression {
    /// Calls `visit` with every name in it.
    pub(super) fn visit_names(&self, visit: &mut dyn FnMut(&str)) {
        match self {
            Self::Number(_) => {}
            Self::Name(name) => visit(name),
            Self::Not(a) | Self::Negative(a) => a.visit_names(visit),
            Self::Binary(_, a, b) => [a, b].into_iter().for_each(|e| e.visit_names(visit)),
            Self::Call(_, arguments) => arguments.iter().for_each(|e| e.visit_names(visit)),
        }
    }

    /// Its finite value; draws are made in the order in which they stand, those of branches not taken not at all.
    ///
    /// # Errors
    /// An unknown name, or a value that is no finite number.
    pub(super) fn value(&self, scope: &mut Scope) -> Result<f64, String> {
        let value = self.raw(scope)?;
        if value.is_finite() { Ok(value) } else { Err(format!("its value is {value}, which is not finite")) }
    }

    /// As [`value`](Self::value), where infinity has a meaning.
    pub(super) fn raw(&self, scope: &mut Scope) -> Result<f64, String> {
        Ok(match self {
            Self::Number(value) => *value,
            Self::Name(name) => scope.get(name)?,
            Self::Not(a) => truth(a.raw(scope)? == 0.0),
            Self::Negative(a) => -a.raw(scope)?,
            Self::Binary(Operator::Or, a, b) => truth(a.raw(scope)? != 0.0 || b.raw(scope)? != 0.0),
            Self::Binary(Operator::And, a, b) => truth(a.raw(scope)? != 0.0 && b.raw(scope)? != 0.0),
            Self::Binary(operator, a, b) => operator.of(a.raw(scope)?, b.raw(scope)?),
            Self::Call(function, arguments) => call(*function, arguments, scope)?,
        })
    }
}

fn truth(is_true: bool) -> f64 {
    f64::from(u8::from(is_true))
}

impl Operator {
    fn of(self, a: f64, b: f64) -> f64 {
        match self {
            Self::Or | Self::And => f64::NAN,
            Self::Equal => truth(a == b),
            Self::Unequal => truth(a != b),
            Self::Less => truth(a < b),
            Self::AtMost => truth(a <= b),
            Self::More => truth(a > b),
            Self::AtLeast => truth(a >= b),
            Self::Add => a + b,
            Self::Subtract => a - b,
            Self::Multiply => a * b,
            Self::Divide => a / b,
            Self::Remainder => a.rem_euclid(b),
        }
    }
}

fn call(function: Function, arguments: &[Expression], scope: &mut Scope) -> Result<f64, String> {
    // These evaluate the argument that they choose alone.
    let chosen = match function {
        Function::If => Some(if arguments[0].raw(scope)? != 0.0 { 1 } else { 2 }),
        Function::ByLevel => Some((scope.get("level")? as usize).min(arguments.len() - 1)),
        Function::Choose => Some(1 + index(arguments[0].raw(scope)?, arguments.len() - 1)?),
        _ => None,
    };
    if let Some(chosen) = chosen {
        return arguments[chosen].raw(scope);
    }
    let values = arguments.iter().map(|e| e.raw(scope)).collect::<Result<Vec<f64>, String>>()?;
    let x = values[0];
    Ok(match function {
        Function::Sin => math::sin(x),
        Function::Cos => math::cos(x),
        Function::Sqrt => x.sqrt(),
        Function::Pow => math::pow(x, values[1]),
        Function::Abs => x.abs(),
        Function::Sign => x.signum(),
        Function::Floor => x.floor(),
        Function::Ceil => x.ceil(),
        Function::Round => x.round(),
        Function::Min => values.iter().copied().fold(f64::INFINITY, f64::min),
        Function::Max => values.iter().copied().fold(f64::NEG_INFINITY, f64::max),
        Function::Ramp => ramp(x, &values[1..])?,
        Function::Range if x <= values[1] => scope.stream.range(x, values[1]),
        Function::Range => {
            return Err(format!("range({x}, {}): the first number must be at most the second", values[1]));
        }
        Function::Chance if (0.0..=1.0).contains(&x) => truth(scope.stream.chance(x)),
        Function::Chance => return Err(format!("chance({x}): expected a probability from 0 to 1")),
        Function::Below if x != 0.0 => scope.stream.below(index(x, 1 << 16)?) as f64,
        Function::Below => return Err("below(0): expected at least 1".to_owned()),
        Function::Weighted if values.iter().all(|w| *w >= 0.0) && values.iter().any(|w| *w > 0.0) => {
            scope.stream.weighted(&values) as f64
        }
        Function::Weighted => return Err("weighted(): expected weights of at least 0, and one above 0".to_owned()),
        Function::If | Function::ByLevel | Function::Choose => f64::NAN,
    })
}

/// A whole number in 0..count.
pub(super) fn index(value: f64, count: usize) -> Result<usize, String> {
    if value.fract() == 0.0 && value >= 0.0 && value < count as f64 {
        Ok(value as usize)
    } else {
        Err(format!("{value} is not a whole number from 0 to {}", count - 1))
    }
}

/// The value at `x` of a line through the points (x0, y0), (x1, y1), ..., level beyond its ends.
fn ramp(x: f64, points: &[f64]) -> Result<f64, String> {
    if !points.len().is_multiple_of(2) {
        return Err("ramp() takes a number and pairs of numbers".to_owned());
    }
    let mut value = points[1];
    for pair in points.windows(4).step_by(2) {
        let [x0, y0, x1, y1] = [pair[0], pair[1], pair[2], pair[3]];
        if x >= x0 {
            value = y0 + (y1 - y0) * ((x - x0) / (x1 - x0)).clamp(0.0, 1.0);
        }
    }
    Ok(value)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::props::parser::Parser;

    fn parse(text: &str) -> Result<Expression, String> {
        let mut parser = Parser::new(text)?;
        let expression = parser.expression()?;
        parser.end()?;
        Ok(expression)
    }

    fn value(text: &str) -> Result<f64, String> {
        let mut scope = Scope::new(Stream::from_seed("test", 0));
        scope.add("w", 1.5);
        scope.add("level", 2.0);
        parse(text)?.value(&mut scope)
    }

    #[test]
    fn operators_bind_as_in_mathematics() {
        for (text, expected) in [
            ("1 + 2 * 3 - 4 / 2", 5.0),
            ("-(1 + 2) * -2", 6.0),
            ("10 - 3 - 2", 5.0),
            ("-1 % 3", 2.0),
            ("1 < 2 && !(2 >= 3) || 0", 1.0),
            ("1 + 1 == 2 && 1 != 2", 1.0),
            ("w * 2 + .5e1", 8.0),
            ("max(1, w, -3) + min(4, 2)", 3.5),
            ("by_level(1, 2, 30)", 30.0),
            ("choose(1, 5, 6 + w, 7)", 7.5),
            ("by_level(1, 2, 3, 40) + level", 5.0),
            ("ramp(0.5, 0, 2, 1, 4, 2, 0)", 3.0),
            ("ramp(9, 0, 2, 1, 4, 2, 0)", 0.0),
            ("ramp(-9, 0, 2, 1, 4, 2, 0)", 2.0),
            ("if(w > 1, w, 1 / 0)", 1.5),
            ("floor(-0.5) + ceil(0.2) + round(2.4) + abs(-3) + sqrt(16)", 9.0),
        ] {
            assert_eq!(value(text), Ok(expected), "{text}");
        }
        assert!((value("sin(pi / 6) + cos(tau)").unwrap() - 1.5).abs() < 1e-12);
    }

    #[test]
    fn draws_keep_to_their_limits_and_to_the_branch_taken() {
        let mut scope = Scope::new(Stream::from_seed("test", 1));
        let mut draw = |text: &str| parse(text).unwrap().value(&mut scope).unwrap();
        for _ in 0..200 {
            assert!((2.0..3.0).contains(&draw("range(2, 3)")));
            assert!([0.0, 1.0, 2.0].contains(&draw("below(3)")));
            assert_eq!(draw("weighted(0, 1, 0)"), 1.0);
        }
        let mut other = scope.stream.clone();
        let skipped = parse("if(0, range(0, 1), 5)").unwrap().value(&mut scope);
        assert_eq!((skipped, scope.stream.next_u64()), (Ok(5.0), other.next_u64()));
    }

    #[test]
    fn bad_expressions_say_what_is_wrong() {
        for (text, part) in [
            ("1 +", "ends too early"),
            ("1 + * 2", "'*'"),
            ("hight", "unknown name \"hight\""),
            ("sine(3)", "unknown function \"sine\"; known: sin, cos"),
            ("pow(2)", "pow() takes 2 arguments, got 1"),
            ("1 / 0", "which is not finite"),
            ("choose(2, 1, 1)", "2 is not a whole number from 0 to 1"),
            ("(1", "')'"),
            ("1 2", "'2'"),
            ("1 ? 2", "'?'"),
            ("ramp(1, 0, 1, 2, 3, 4)", "pairs"),
            ("range(2, 1)", "at most the second"),
            ("range(sqrt(-1), 1)", "at most the second"),
            ("chance(5)", "expected a probability"),
            ("below(0)", "expected at least 1"),
            ("weighted(-1, 2)", "weights of at least 0"),
            ("weighted(0, 0)", "weights of at least 0"),
        ] {
            let error = value(text).unwrap_err();
            assert!(error.contains(part), "{text}: {error}");
        }
        assert!(value(&"(".repeat(5000)).unwrap_err().contains("nested"));
        assert!(value(&"-".repeat(5000)).unwrap_err().contains("nested"));
    }
}
