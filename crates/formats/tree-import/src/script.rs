//! The scripts of BehaviorTree.CPP: assignments of constants, and conditions.

/// A value in a script.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Constant {
    Bool(bool),
    Number(f64),
    Text(String),
}

/// The source of an assignment.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Source {
    Constant(Constant),
    Key(String),
}

/// `KEY := SOURCE`.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Assignment {
    pub key: String,
    pub from: Source,
}

/// A condition. Comparisons have the key on the left.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Expr {
    Constant(bool),
    Key(String),
    Equals(String, Constant),
    Below(String, f64),
    Above(String, f64),
    Not(Box<Expr>),
    And(Vec<Expr>),
    Or(Vec<Expr>),
}

/// Largest nesting of parentheses and of `!`.
// Bounds the recursion of the parser, which has the stack of the program.
const MAX_DEPTH: usize = 32;

#[derive(Clone, Debug, PartialEq)]
enum Token {
    Constant(Constant),
    Name(String),
    Operator(&'static str),
}

// Longer operators come first: `<` would match the start of `<=`. Operators without a
// counterpart are listed as well, so that the message explains the possible ones.
const OPERATORS: &[&str] = &[
    ":=", "+=", "-=", "*=", "/=", "==", "!=", "<=", ">=", "&&", "||", "=", "<", ">", "!", "(", ")",
    ";", "+", "-", "*", "/", "&", "|", "^", "~", "?", ":", "..",
];

fn tokens(text: &str) -> Result<Vec<Token>, String> {
    let mut tokens = Vec::new();
    let mut rest = text.trim_start();
    while let Some(first) = rest.chars().next() {
        let length;
        if first == '\'' || first == '"' {
            let end = rest.get(1..).and_then(|inner| inner.find(first));
            let end = end.ok_or_else(|| format!("{first} is not closed in '{text}'"))?;
            let inner = rest.get(1..=end).unwrap_or_default();
            tokens.push(Token::Constant(Constant::Text(inner.to_owned())));
            length = end + 2;
        } else if first.is_ascii_digit() || (first == '-' && is_sign(rest, &tokens)) {
            length = number_length(rest);
            let word = rest.get(..length).unwrap_or_default();
            tokens.push(Token::Constant(Constant::Number(number(word)?)));
        } else if first.is_alphabetic() || first == '_' || first == '@' {
            let inside = |c: char| c.is_alphanumeric() || c == '_';
            let end = rest.char_indices().skip(1).find(|(_, c)| !inside(*c));
            length = end.map_or(rest.len(), |(at, _)| at);
            let word = rest.get(..length).unwrap_or_default();
            tokens.push(match word {
                "true" => Token::Constant(Constant::Bool(true)),
                "false" => Token::Constant(Constant::Bool(false)),
                name => Token::Name(name.to_owned()),
            });
        } else {
            let found = OPERATORS
                .iter()
                .find(|operator| rest.starts_with(**operator));
            let operator = found.ok_or_else(|| format!("'{first}' in '{text}' is not known"))?;
            tokens.push(Token::Operator(operator));
            length = operator.len();
        }
        rest = rest.get(length..).unwrap_or_default().trim_start();
    }
    Ok(tokens)
}

/// Whether a minus belongs to a number: no operand is before it.
fn is_sign(rest: &str, before: &[Token]) -> bool {
    let digit = rest.chars().nth(1).is_some_and(|c| c.is_ascii_digit());
    let operand = matches!(
        before.last(),
        Some(Token::Constant(_) | Token::Name(_) | Token::Operator(")"))
    );
    digit && !operand
}

fn number_length(text: &str) -> usize {
    let bytes = text.as_bytes();
    let mut at = 1;
    while let Some(byte) = bytes.get(at) {
        // The sign of an exponent belongs to the number: `1e-3`.
        let exponent = matches!(bytes.get(at - 1), Some(b'e' | b'E')) && !text.starts_with("0x");
        let inside = byte.is_ascii_alphanumeric()
            || *byte == b'.'
            || (exponent && matches!(byte, b'+' | b'-'));
        if !inside {
            break;
        }
        at += 1;
    }
    at
}

fn number(word: &str) -> Result<f64, String> {
    let hex = word.strip_prefix("0x").or(word.strip_prefix("0X"));
    let value = match hex {
        Some(digits) => i64::from_str_radix(digits, 16)
            .ok()
            .map(|value| value as f64),
        None => word.parse().ok(),
    };
    value
        .filter(|value: &f64| value.is_finite())
        .ok_or_else(|| format!("'{word}' is not a number"))
}

/// The assignments of a script.
///
/// # Errors
/// The part without a counterpart.
pub(crate) fn assignments(text: &str) -> Result<Vec<Assignment>, String> {
    let tokens = tokens(text)?;
    let statements = tokens.split(|token| *token == Token::Operator(";"));
    let made: Result<Vec<_>, String> = statements
        .filter(|statement| !statement.is_empty())
        .map(|statement| match statement {
            [Token::Name(key), Token::Operator(":=" | "="), from] => {
                // `KEY := OTHER_KEY` copies a value, which a node can do; anything else
                // computes.
                let from = match from {
                    Token::Constant(constant) => Source::Constant(constant.clone()),
                    Token::Name(other) => Source::Key(other.clone()),
                    Token::Operator(_) => return Err(only_constants(text)),
                };
                Ok(Assignment {
                    key: key.clone(),
                    from,
                })
            }
            _ => Err(only_constants(text)),
        })
        .collect();
    match made {
        Ok(made) if made.is_empty() => Err("the script is empty".to_owned()),
        made => made,
    }
}

fn only_constants(text: &str) -> String {
    format!(
        "the script '{text}' computes; only 'KEY := CONSTANT' and 'KEY := OTHER_KEY' have a \
         counterpart: compute it in a leaf"
    )
}

/// A condition.
///
/// # Errors
/// The part without a counterpart.
pub(crate) fn condition(text: &str) -> Result<Expr, String> {
    let tokens = tokens(text)?;
    let mut parser = Parser {
        text,
        tokens: &tokens,
        at: 0,
    };
    let expr = parser.any_of(0)?;
    // A rest means that only a part of the condition was understood.
    if parser.at < tokens.len() {
        return Err(parser.wrong());
    }
    Ok(expr)
}

struct Parser<'t> {
    text: &'t str,
    tokens: &'t [Token],
    at: usize,
}

impl Parser<'_> {
    fn peek(&self) -> Option<&Token> {
        self.tokens.get(self.at)
    }

    fn takes(&mut self, operator: &'static str) -> bool {
        let found = self.peek() == Some(&Token::Operator(operator));
        self.at += usize::from(found);
        found
    }

    fn wrong(&self) -> String {
        format!(
            "the condition '{}' has no counterpart; a key is compared with a constant (==, !=, <, \
             <=, >, >=), and comparisons are joined by &&, || and !",
            self.text
        )
    }

    fn any_of(&mut self, depth: usize) -> Result<Expr, String> {
        // Counted at each level of parentheses; `!` is counted below.
        if depth > MAX_DEPTH {
            return Err(format!(
                "a condition is nested deeper than {MAX_DEPTH} levels"
            ));
        }
        let mut parts = vec![self.all_of(depth)?];
        while self.takes("||") {
            parts.push(self.all_of(depth)?);
        }
        Ok(match parts.len() {
            1 => parts.swap_remove(0),
            _ => Expr::Or(parts),
        })
    }

    fn all_of(&mut self, depth: usize) -> Result<Expr, String> {
        let mut parts = vec![self.comparison(depth)?];
        while self.takes("&&") {
            parts.push(self.comparison(depth)?);
        }
        Ok(match parts.len() {
            1 => parts.swap_remove(0),
            _ => Expr::And(parts),
        })
    }

    fn comparison(&mut self, depth: usize) -> Result<Expr, String> {
        if self.takes("!") {
            if depth > MAX_DEPTH {
                return Err(format!(
                    "a condition is nested deeper than {MAX_DEPTH} levels"
                ));
            }
            return Ok(not(self.comparison(depth + 1)?));
        }
        if self.takes("(") {
            let inner = self.any_of(depth + 1)?;
            if !self.takes(")") {
                return Err(self.wrong());
            }
            return Ok(inner);
        }
        let left = self.peek().cloned();
        self.at += 1;
        let operator = match self.peek() {
            Some(Token::Operator(o @ ("==" | "!=" | "<" | "<=" | ">" | ">="))) => Some(*o),
            _ => None,
        };
        let Some(operator) = operator else {
            return match left {
                Some(Token::Name(key)) => Ok(Expr::Key(key)),
                Some(Token::Constant(Constant::Bool(value))) => Ok(Expr::Constant(value)),
                _ => Err(self.wrong()),
            };
        };
        self.at += 1;
        let right = self.peek().cloned();
        self.at += 1;
        // Two keys or two constants have no counterpart: our test compares a key with a
        // constant.
        let compared = match (left, right) {
            (Some(Token::Name(key)), Some(Token::Constant(constant))) => {
                compare(key, operator, constant)
            }
            (Some(Token::Constant(constant)), Some(Token::Name(key))) => {
                compare(key, turned(operator), constant)
            }
            _ => None,
        };
        compared.ok_or_else(|| self.wrong())
    }
}

fn not(expr: Expr) -> Expr {
    Expr::Not(Box::new(expr))
}

fn turned(operator: &'static str) -> &'static str {
    match operator {
        "<" => ">",
        "<=" => ">=",
        ">" => "<",
        ">=" => "<=",
        same => same,
    }
}

fn compare(key: String, operator: &str, constant: Constant) -> Option<Expr> {
    let number = match constant {
        Constant::Number(number) => Some(number),
        _ => None,
    };
    Some(match operator {
        "==" => Expr::Equals(key, constant),
        "!=" => not(Expr::Equals(key, constant)),
        "<" => Expr::Below(key, number?),
        ">" => Expr::Above(key, number?),
        // `<=` is "not above": for a key without a value it holds, as the documentation of the
        // crate says.
        "<=" => not(Expr::Above(key, number?)),
        _ => not(Expr::Below(key, number?)),
    })
}
