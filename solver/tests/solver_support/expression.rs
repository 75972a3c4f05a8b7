//! Expressions from text.

/// A node; arguments come before the nodes that use them.
#[derive(Debug, Clone, Copy)]
enum Node {
    Constant(f64),
    Variable(usize),
    Sum(usize, usize),
    Product(usize, usize),
    Unary(Function, usize),
}

#[derive(Debug, Clone, Copy)]
pub(crate) enum Function {
    Negative,
    Reciprocal,
    /// Integer power, also of negative arguments.
    Power(i32),
    /// Real power.
    RealPower(f64),
    Exponential,
    Logarithm,
    SquareRoot,
    Sine,
    Cosine,
    ArcTangent,
    HyperbolicTangent,
}

impl Function {
    /// Number and parameter bits of the function.
    fn key(self) -> (u8, u64) {
        match self {
            Self::Negative => (0, 0),
            Self::Reciprocal => (1, 0),
            Self::Power(k) => (2, f64::from(k).to_bits()),
            Self::RealPower(p) => (3, p.to_bits()),
            Self::Exponential => (4, 0),
            Self::Logarithm => (5, 0),
            Self::SquareRoot => (6, 0),
            Self::Sine => (7, 0),
            Self::Cosine => (8, 0),
            Self::ArcTangent => (9, 0),
            Self::HyperbolicTangent => (10, 0),
        }
    }

    /// Inverse of [`Function::key`].
    pub(crate) fn from_key((number, bits): (u8, u64)) -> Self {
        let parameter = f64::from_bits(bits);
        match number {
            0 => Self::Negative,
            1 => Self::Reciprocal,
            2 => Self::Power(parameter as i32),
            3 => Self::RealPower(parameter),
            4 => Self::Exponential,
            5 => Self::Logarithm,
            6 => Self::SquareRoot,
            7 => Self::Sine,
            8 => Self::Cosine,
            9 => Self::ArcTangent,
            _ => Self::HyperbolicTangent,
        }
    }

    /// Value, first and second derivative.
    pub(crate) fn evaluate(self, a: f64) -> (f64, f64, f64) {
        match self {
            Self::Negative => (-a, -1.0, 0.0),
            Self::Reciprocal => (1.0 / a, -1.0 / (a * a), 2.0 / (a * a * a)),
            Self::Power(k) => {
                let (first, second) = match k {
                    0 => (0.0, 0.0),
                    1 => (1.0, 0.0),
                    _ => (
                        f64::from(k) * a.powi(k - 1),
                        f64::from(k) * f64::from(k - 1) * a.powi(k - 2),
                    ),
                };
                (a.powi(k), first, second)
            }
            Self::RealPower(p) => (
                a.powf(p),
                p * a.powf(p - 1.0),
                p * (p - 1.0) * a.powf(p - 2.0),
            ),
            Self::Exponential => (a.exp(), a.exp(), a.exp()),
            Self::Logarithm => (a.ln(), 1.0 / a, -1.0 / (a * a)),
            Self::SquareRoot => {
                let root = a.sqrt();
                (root, 0.5 / root, -0.25 / (root * a))
            }
            Self::Sine => (a.sin(), a.cos(), -a.sin()),
            Self::Cosine => (a.cos(), -a.sin(), -a.cos()),
            Self::ArcTangent => {
                let d = 1.0 / (1.0 + a * a);
                (a.atan(), d, -2.0 * a * d * d)
            }
            Self::HyperbolicTangent => {
                let t = a.tanh();
                (t, 1.0 - t * t, -2.0 * t * (1.0 - t * t))
            }
        }
    }
}

/// An expression in `x1, x2, ...`.
#[derive(Debug, Clone)]
pub(crate) struct Expression {
    nodes: Vec<Node>,
    /// Indices of the variables that occur.
    pub(crate) variables: Vec<usize>,
}

impl Expression {
    /// Reads `text`; panics with the text where it is not an expression.
    ///
    /// Either infix, or `tape` and one node a word: `x3`, `#0.5`, `+0,1` (nodes 0 and 1), `-0,1`, `*0,1`,
    /// `/0,1`, `pow0,2.5`, `sin0` and the other functions; the last node is the value.
    pub(crate) fn parse(text: &str) -> Self {
        if let Some(words) = text.strip_prefix("tape ") {
            return Self::with_nodes(read_tape(words));
        }
        let mut parser = Parser {
            bytes: text.as_bytes(),
            position: 0,
            nodes: Vec::new(),
        };
        parser.sum();
        parser.blanks();
        assert_eq!(parser.position, text.len(), "trailing text in `{text}`");
        Self::with_nodes(parser.nodes)
    }

    fn with_nodes(nodes: Vec<Node>) -> Self {
        let mut variables: Vec<usize> = nodes
            .iter()
            .filter_map(|node| match node {
                Node::Variable(i) => Some(*i),
                _ => None,
            })
            .collect();
        variables.sort_unstable();
        variables.dedup();
        Self { nodes, variables }
    }
    /// The expression with its constants and variables taken out: equal shapes can be evaluated together.
    pub(crate) fn shape(&self) -> (Shape, Vec<f64>, Vec<usize>) {
        let mut constants = Vec::new();
        let mut variables: Vec<usize> = Vec::new();
        let nodes = self
            .nodes
            .iter()
            .map(|node| match *node {
                Node::Constant(c) => {
                    constants.push(c);
                    Slot::Constant(constants.len() - 1)
                }
                Node::Variable(i) => {
                    let known = variables.iter().position(|&v| v == i);
                    Slot::Variable(known.unwrap_or_else(|| {
                        variables.push(i);
                        variables.len() - 1
                    }))
                }
                Node::Sum(p, q) => Slot::Sum(p, q),
                Node::Product(p, q) => Slot::Product(p, q),
                Node::Unary(f, p) => Slot::Unary(f.key(), p),
            })
            .collect();
        (Shape(nodes), constants, variables)
    }
}

/// Nodes without constants and variable names; functions by their bits, so that shapes can be compared.
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub(crate) struct Shape(pub(crate) Vec<Slot>);

#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub(crate) enum Slot {
    Constant(usize),
    Variable(usize),
    Sum(usize, usize),
    Product(usize, usize),
    Unary((u8, u64), usize),
}

fn read_tape(words: &str) -> Vec<Node> {
    let mut nodes = Vec::new();
    // position of each word's value, since quotients and differences take two nodes
    let mut places = Vec::new();
    for word in words.split_whitespace() {
        let split = word
            .find(|c: char| c.is_ascii_digit() || c == '-' && !word.starts_with('-'))
            .unwrap_or(word.len());
        let split = split.max(1);
        let (head, tail) = if word.starts_with('#') {
            word.split_at(1)
        } else {
            word.split_at(split)
        };
        let argument = |text: &str| places[text.parse::<usize>().unwrap()];
        let pair = || {
            let (a, b) = tail.split_once(',').unwrap();
            (argument(a), argument(b))
        };
        let node = match head {
            "#" => Node::Constant(tail.parse().unwrap()),
            "x" => Node::Variable(tail.parse::<usize>().unwrap() - 1),
            "+" => Node::Sum(pair().0, pair().1),
            "*" => Node::Product(pair().0, pair().1),
            "-" | "/" => {
                let (a, b) = pair();
                let function = if head == "-" {
                    Function::Negative
                } else {
                    Function::Reciprocal
                };
                nodes.push(Node::Unary(function, b));
                let b = nodes.len() - 1;
                if head == "-" {
                    Node::Sum(a, b)
                } else {
                    Node::Product(a, b)
                }
            }
            "pow" => {
                let (a, p) = tail.split_once(',').unwrap();
                Node::Unary(power(p.parse().unwrap()), argument(a))
            }
            name => Node::Unary(function(name), argument(tail)),
        };
        nodes.push(node);
        places.push(nodes.len() - 1);
    }
    nodes
}

fn power(exponent: f64) -> Function {
    if exponent.fract() == 0.0 && exponent.abs() < 100.0 {
        Function::Power(exponent as i32)
    } else {
        Function::RealPower(exponent)
    }
}

fn function(name: &str) -> Function {
    match name {
        "neg" => Function::Negative,
        "inv" => Function::Reciprocal,
        "exp" => Function::Exponential,
        "log" => Function::Logarithm,
        "sqrt" => Function::SquareRoot,
        "sin" => Function::Sine,
        "cos" => Function::Cosine,
        "atan" => Function::ArcTangent,
        "tanh" => Function::HyperbolicTangent,
        _ => panic!("unknown function `{name}`"),
    }
}

struct Parser<'t> {
    bytes: &'t [u8],
    position: usize,
    nodes: Vec<Node>,
}

impl Parser<'_> {
    fn push(&mut self, node: Node) -> usize {
        self.nodes.push(node);
        self.nodes.len() - 1
    }

    fn blanks(&mut self) {
        while self.bytes.get(self.position) == Some(&b' ') {
            self.position += 1;
        }
    }

    fn take(&mut self, wanted: u8) -> bool {
        self.blanks();
        let found = self.bytes.get(self.position) == Some(&wanted);
        self.position += usize::from(found);
        found
    }

    fn sum(&mut self) -> usize {
        let mut left = self.term();
        loop {
            if self.take(b'+') {
                let right = self.term();
                left = self.push(Node::Sum(left, right));
            } else if self.take(b'-') {
                let right = self.term();
                let right = self.push(Node::Unary(Function::Negative, right));
                left = self.push(Node::Sum(left, right));
            } else {
                return left;
            }
        }
    }

    fn term(&mut self) -> usize {
        let mut left = self.signed();
        loop {
            if self.take(b'*') {
                let right = self.signed();
                left = self.push(Node::Product(left, right));
            } else if self.take(b'/') {
                let right = self.signed();
                let right = self.push(Node::Unary(Function::Reciprocal, right));
                left = self.push(Node::Product(left, right));
            } else {
                return left;
            }
        }
    }

    fn signed(&mut self) -> usize {
        if self.take(b'-') {
            let argument = self.signed();
            return self.push(Node::Unary(Function::Negative, argument));
        }
        let base = self.atom();
        if !self.take(b'^') {
            return base;
        }
        let negative = self.take(b'-');
        let bracket = self.take(b'(');
        let negative = negative ^ (bracket && self.take(b'-'));
        let magnitude = self.number();
        assert!(!bracket || self.take(b')'), "exponents are numbers");
        let exponent = if negative { -magnitude } else { magnitude };
        let function = power(exponent);
        self.push(Node::Unary(function, base))
    }

    fn number(&mut self) -> f64 {
        self.blanks();
        let start = self.position;
        let mut previous = b' ';
        while let Some(&byte) = self.bytes.get(self.position) {
            let exponent_sign = matches!(byte, b'+' | b'-') && previous == b'e';
            if !(byte.is_ascii_digit() || byte == b'.' || byte == b'e' || exponent_sign) {
                break;
            }
            previous = byte;
            self.position += 1;
        }
        let text = std::str::from_utf8(&self.bytes[start..self.position]).unwrap();
        text.parse()
            .unwrap_or_else(|_| panic!("`{text}` is not a number, at byte {start}"))
    }

    fn atom(&mut self) -> usize {
        self.blanks();
        if self.take(b'(') {
            let inner = self.sum();
            assert!(self.take(b')'), "missing bracket");
            return inner;
        }
        if self.bytes[self.position].is_ascii_digit() || self.bytes[self.position] == b'.' {
            let value = self.number();
            return self.push(Node::Constant(value));
        }
        let start = self.position;
        while self.position < self.bytes.len() && self.bytes[self.position].is_ascii_alphanumeric()
        {
            self.position += 1;
        }
        let name = std::str::from_utf8(&self.bytes[start..self.position]).unwrap();
        if let Some(index) = name.strip_prefix('x').and_then(|k| k.parse::<usize>().ok()) {
            return self.push(Node::Variable(index - 1));
        }
        let function = function(name);
        assert!(self.take(b'('), "missing bracket after {name}");
        let argument = self.sum();
        assert!(self.take(b')'), "missing bracket after {name}");
        self.push(Node::Unary(function, argument))
    }
}
