//! Reads expressions, lists of points, and loops.

use super::expression::{Expression, Function, Operator};

/// Parentheses, calls, and signs in each other.
const MOST_NESTED: usize = 40;

#[derive(Debug, Clone, PartialEq)]
enum Token {
    Number(f64),
    Word(String),
    Sign(&'static str),
}

/// The signs, longer ones first.
const SIGNS: [&str; 20] =
    ["..", "||", "&&", "==", "!=", "<=", ">=", "<", ">", "+", "-", "*", "/", "%", "!", "(", ")", ",", ";", "="];

/// What binds how strongly, from the weakest.
const BINDING: [&[(&str, Operator)]; 5] = [
    &[("||", Operator::Or)],
    &[("&&", Operator::And)],
    &[
        ("==", Operator::Equal),
        ("!=", Operator::Unequal),
        ("<=", Operator::AtMost),
        (">=", Operator::AtLeast),
        ("<", Operator::Less),
        (">", Operator::More),
    ],
    &[("+", Operator::Add), ("-", Operator::Subtract)],
    &[("*", Operator::Multiply), ("/", Operator::Divide), ("%", Operator::Remainder)],
];

/// What a name in a loop stands for: every whole number from one to before another, or each of a list.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Values {
    Range(Expression, Expression),
    List(Vec<Expression>),
}

/// A name and the values that it takes one after the other.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Loop {
    pub name: String,
    pub values: Values,
}

/// A point of a list, or as many as a loop makes.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Point {
    pub coordinates: Vec<Expression>,
    pub each: Option<Loop>,
}

/// The rest of a text.
pub(super) struct Parser {
    /// In reverse.
    tokens: Vec<Token>,
    depth: usize,
}

impl Parser {
    /// # Errors
    /// A character that means nothing.
    pub(super) fn new(text: &str) -> Result<Self, String> {
        let mut tokens = Vec::new();
        let mut rest = text.trim_start();
        while let Some(first) = rest.chars().next() {
            let length = if first.is_ascii_digit() || is_decimal_point(rest) {
                let length = number_length(rest);
                let number = rest[..length].parse().map_err(|_| format!("{:?} is not a number", &rest[..length]))?;
                tokens.push(Token::Number(number));
                length
            } else if first.is_ascii_alphabetic() || first == '_' {
                let length = rest.find(|c: char| !c.is_ascii_alphanumeric() && c != '_').unwrap_or(rest.len());
                tokens.push(Token::Word(rest[..length].to_owned()));
                length
            } else {
                let sign = SIGNS.into_iter().find(|sign| rest.starts_with(sign));
                let sign = sign.ok_or_else(|| format!("unexpected {first:?}"))?;
                tokens.push(Token::Sign(sign));
                sign.len()
            };
            rest = rest[length..].trim_start();
        }
        tokens.reverse();
        Ok(Self { tokens, depth: 0 })
    }

    fn takes(&mut self, sign: &str) -> bool {
        let is_next = matches!(self.tokens.last(), Some(Token::Sign(next)) if *next == sign);
        if is_next {
            self.tokens.pop();
        }
        is_next
    }

    fn takes_word(&mut self, word: &str) -> bool {
        let is_next = matches!(self.tokens.last(), Some(Token::Word(next)) if next == word);
        if is_next {
            self.tokens.pop();
        }
        is_next
    }

    fn expect(&mut self, sign: &str) -> Result<(), String> {
        if self.takes(sign) { Ok(()) } else { Err(format!("expected '{sign}', got {}", self.next())) }
    }

    /// The next token, in words.
    fn next(&self) -> String {
        match self.tokens.last() {
            None => "the end".to_owned(),
            Some(Token::Number(number)) => format!("'{number}'"),
            Some(Token::Word(word)) => format!("'{word}'"),
            Some(Token::Sign(sign)) => format!("'{sign}'"),
        }
    }

    pub(super) fn end(&self) -> Result<(), String> {
        if self.tokens.is_empty() { Ok(()) } else { Err(format!("unexpected {}", self.next())) }
    }

    pub(super) fn expression(&mut self) -> Result<Expression, String> {
        self.bound(0)
    }

    /// An expression whose operators bind at least so strongly.
    fn bound(&mut self, strength: usize) -> Result<Expression, String> {
        let Some(operators) = BINDING.get(strength) else { return self.signed() };
        let mut left = self.bound(strength + 1)?;
        while let Some((_, operator)) = operators.iter().find(|(sign, _)| self.takes(sign)) {
            left = Expression::Binary(*operator, Box::new(left), Box::new(self.bound(strength + 1)?));
        }
        Ok(left)
    }

    fn signed(&mut self) -> Result<Expression, String> {
        self.depth += 1;
        if self.depth > MOST_NESTED {
            return Err(format!("nested more than {MOST_NESTED} times"));
        }
        let found = if self.takes("-") {
            Expression::Negative(Box::new(self.signed()?))
        } else if self.takes("!") {
            Expression::Not(Box::new(self.signed()?))
        } else {
            self.operand()?
        };
        self.depth -= 1;
        Ok(found)
    }

    fn operand(&mut self) -> Result<Expression, String> {
        if self.takes("(") {
            let inner = self.expression()?;
            self.expect(")")?;
            return Ok(inner);
        }
        match self.tokens.pop() {
            Some(Token::Number(number)) => Ok(Expression::Number(number)),
            Some(Token::Word(word)) if self.takes("(") => self.call(&word),
            Some(Token::Word(word)) => Ok(match word.as_str() {
                "pi" => Expression::Number(cadet_base::math::PI),
                "tau" => Expression::Number(cadet_base::math::TAU),
                "inf" => Expression::Number(f64::INFINITY),
                _ => Expression::Name(word),
            }),
            Some(Token::Sign(sign)) => Err(format!("unexpected '{sign}'")),
            None => Err("it ends too early".to_owned()),
        }
    }

    fn call(&mut self, name: &str) -> Result<Expression, String> {
        let known = || format!("unknown function {name:?}; known: {}", Function::NAMES.join(", "));
        let function = Function::from_name(name).ok_or_else(known)?;
        let arguments = self.tuple()?;
        self.expect(")")?;
        let (_, least, most) = function.signature();
        if (least..=most).contains(&arguments.len()) {
            return Ok(Expression::Call(function, arguments));
        }
        let takes = if least == most { least.to_string() } else { format!("{least} to {most}") };
        Err(format!("{name}() takes {takes} arguments, got {}", arguments.len()))
    }

    /// Expressions with commas between.
    pub(super) fn tuple(&mut self) -> Result<Vec<Expression>, String> {
        let mut found = vec![self.expression()?];
        while self.takes(",") {
            found.push(self.expression()?);
        }
        Ok(found)
    }

    fn name(&mut self) -> Result<String, String> {
        match self.tokens.pop() {
            Some(Token::Word(word)) => Ok(word),
            _ => Err("expected a name".to_owned()),
        }
    }

    /// `name = expression`.
    pub(super) fn definition(&mut self) -> Result<(String, Expression), String> {
        let name = self.name()?;
        self.expect("=")?;
        Ok((name, self.expression()?))
    }

    /// `name in first..end` or `name in a, b, c`.
    fn each(&mut self) -> Result<Loop, String> {
        let name = self.name()?;
        if !self.takes_word("in") {
            return Err(format!("expected 'in' after {name:?}, got {}", self.next()));
        }
        let first = self.expression()?;
        let values = if self.takes("..") {
            Values::Range(first, self.expression()?)
        } else {
            let mut list = vec![first];
            while self.takes(",") {
                list.push(self.expression()?);
            }
            Values::List(list)
        };
        Ok(Loop { name, values })
    }

    /// Loops with semicolons between, the outermost first.
    pub(super) fn loops(&mut self) -> Result<Vec<Loop>, String> {
        let mut found = vec![self.each()?];
        while self.takes(";") {
            found.push(self.each()?);
        }
        Ok(found)
    }

    /// Points with semicolons between; `x, y for k in 0..5` are five.
    pub(super) fn points(&mut self) -> Result<Vec<Point>, String> {
        let mut found = Vec::new();
        loop {
            let coordinates = self.tuple()?;
            let each = if self.takes_word("for") { Some(self.each()?) } else { None };
            found.push(Point { coordinates, each });
            if !self.takes(";") {
                return Ok(found);
            }
        }
    }
}

fn is_decimal_point(rest: &str) -> bool {
    rest.starts_with('.') && rest[1..].starts_with(|c: char| c.is_ascii_digit())
}

/// The length of the number at the start of a text: `0..3` begins with the number 0.
fn number_length(text: &str) -> usize {
    let digits = |from: usize| from + text[from..].find(|c: char| !c.is_ascii_digit()).unwrap_or(text.len() - from);
    let mut end = digits(0);
    if text[end..].starts_with('.') && !text[end..].starts_with("..") {
        end = digits(end + 1);
    }
    if text[end..].starts_with(['e', 'E']) {
        let sign = usize::from(text[end + 1..].starts_with(['+', '-']));
        if digits(end + 1 + sign) > end + 1 + sign {
            end = digits(end + 1 + sign);
        }
    }
    end
}
