//! Expressions as the words of `.nl` files, in Polish notation.

/// Reads `text`; panics with the text where it is not an expression.
///
/// Either infix, or `tape` and one node a word: `x3`, `#0.5`, `+0,1` (nodes 0 and 1), `-0,1`, `*0,1`, `/0,1`, `pow0,2.5`,
/// `sin0` and the other functions; the last node is the value. Nodes of tapes are common expressions, which `common` has
/// from variable `first` on.
pub(crate) fn words(text: &str, first: usize, common: &mut Vec<String>) -> String {
    if let Some(nodes) = text.strip_prefix("tape ") {
        return tape(nodes, first, common);
    }
    let mut parser = Parser { rest: text.trim() };
    let words = parser.sum();
    assert!(parser.rest.is_empty(), "trailing text in `{text}`");
    words
}

fn tape(nodes: &str, first: usize, common: &mut Vec<String>) -> String {
    let begin = first + common.len();
    for word in nodes.split_whitespace() {
        let split = word.find(|c: char| c.is_ascii_digit() || c == '-');
        let split = if word.starts_with('#') {
            1
        } else {
            split.unwrap_or(1).max(1)
        };
        let (head, tail) = word.split_at(split);
        let argument = |text: &str| format!("v{}", begin + text.parse::<usize>().unwrap());
        let (a, b) = tail.split_once(',').unwrap_or((tail, ""));
        common.push(match head {
            "#" => format!("n{tail}"),
            "x" => variable(tail),
            "pow" => format!("o5 {} n{b}", argument(a)),
            name if b.is_empty() => function(name, &argument(a)),
            name => format!("{} {} {}", operator(name), argument(a), argument(b)),
        });
    }
    format!("v{}", first + common.len() - 1)
}

fn variable(number: &str) -> String {
    format!("v{}", number.parse::<usize>().unwrap() - 1)
}

fn operator(sign: &str) -> &'static str {
    match sign {
        "+" => "o0",
        "-" => "o1",
        "*" => "o2",
        "/" => "o3",
        _ => panic!("unknown operator `{sign}`"),
    }
}

fn function(name: &str, argument: &str) -> String {
    let code = match name {
        "neg" => "o16",
        "inv" => "o3 n1",
        "exp" => "o44",
        "log" => "o43",
        "sqrt" => "o39",
        "sin" => "o41",
        "cos" => "o46",
        "atan" => "o49",
        "tanh" => "o37",
        _ => panic!("unknown function `{name}`"),
    };
    format!("{code} {argument}")
}

struct Parser<'t> {
    rest: &'t str,
}

impl<'t> Parser<'t> {
    fn take(&mut self, wanted: &str) -> bool {
        let rest = self.rest.strip_prefix(wanted);
        self.rest = rest.unwrap_or(self.rest).trim_start();
        rest.is_some()
    }

    /// The longest begin of such bytes.
    fn word(&mut self, is_part: impl Fn(usize, u8) -> bool) -> &'t str {
        let mut bytes = self.rest.bytes().enumerate();
        let end = bytes.position(|(at, byte)| !is_part(at, byte));
        let (word, rest) = self.rest.split_at(end.unwrap_or(self.rest.len()));
        self.rest = rest.trim_start();
        word
    }

    fn sum(&mut self) -> String {
        self.left_to_right(["+", "-"], Self::term)
    }

    fn term(&mut self) -> String {
        self.left_to_right(["*", "/"], Self::signed)
    }

    fn left_to_right(&mut self, signs: [&str; 2], part: fn(&mut Self) -> String) -> String {
        let mut left = part(self);
        while let Some(sign) = signs.into_iter().find(|sign| self.take(sign)) {
            left = format!("{} {left} {}", operator(sign), part(self));
        }
        left
    }

    fn signed(&mut self) -> String {
        if self.take("-") {
            return function("neg", &self.signed());
        }
        let base = self.atom();
        if !self.take("^") {
            return base;
        }
        let is_negative = self.take("-");
        let has_bracket = self.take("(");
        let is_negative = is_negative ^ (has_bracket && self.take("-"));
        let sign = if is_negative { "-" } else { "" };
        let exponent = self.number();
        assert!(!has_bracket || self.take(")"), "exponents are numbers");
        format!("o5 {base} n{sign}{exponent}")
    }

    fn number(&mut self) -> &'t str {
        let text = self.rest.as_bytes();
        self.word(|at, byte| {
            let is_sign = matches!(byte, b'+' | b'-') && at > 0 && text[at - 1] == b'e';
            byte.is_ascii_digit() || matches!(byte, b'.' | b'e') || is_sign
        })
    }

    fn atom(&mut self) -> String {
        if self
            .rest
            .starts_with(|c: char| c.is_ascii_digit() || c == '.')
        {
            return format!("n{}", self.number());
        }
        let name = self.word(|_, byte| byte.is_ascii_alphanumeric());
        if let Some(number) = name.strip_prefix('x') {
            return variable(number);
        }
        assert!(self.take("("), "missing bracket before `{}`", self.rest);
        let argument = self.sum();
        assert!(self.take(")"), "missing bracket before `{}`", self.rest);
        match name {
            "" => argument,
            name => function(name, &argument),
        }
    }
}
