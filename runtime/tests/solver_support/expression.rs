//! Expressions from text, with exact first and second derivatives on a tape.

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
enum Function {
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
    /// Value, first and second derivative.
    fn evaluate(self, a: f64) -> (f64, f64, f64) {
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
    pub(crate) fn parse(text: &str) -> Self {
        let mut parser = Parser {
            bytes: text.as_bytes(),
            position: 0,
            nodes: Vec::new(),
        };
        parser.sum();
        parser.blanks();
        assert_eq!(parser.position, text.len(), "trailing text in `{text}`");
        let mut variables: Vec<usize> = parser
            .nodes
            .iter()
            .filter_map(|node| match node {
                Node::Variable(i) => Some(*i),
                _ => None,
            })
            .collect();
        variables.sort_unstable();
        variables.dedup();
        Self {
            nodes: parser.nodes,
            variables,
        }
    }

    pub(crate) fn value(&self, x: &[f64], work: &mut Work) -> f64 {
        self.forward(x, work);
        work.value[self.nodes.len() - 1]
    }

    /// Adds `weight` times the gradient.
    pub(crate) fn add_gradient(
        &self,
        x: &[f64],
        weight: f64,
        work: &mut Work,
        gradient: &mut dyn FnMut(usize, f64),
    ) {
        self.forward(x, work);
        let n = self.nodes.len();
        work.bar[..n].fill(0.0);
        work.bar[n - 1] = weight;
        for (k, node) in self.nodes.iter().enumerate().rev() {
            let b = work.bar[k];
            match *node {
                Node::Constant(_) => {}
                Node::Variable(i) => gradient(i, b),
                Node::Sum(p, q) => {
                    work.bar[p] += b;
                    work.bar[q] += b;
                }
                Node::Product(p, q) => {
                    work.bar[p] += b * work.value[q];
                    work.bar[q] += b * work.value[p];
                }
                Node::Unary(_, a) => work.bar[a] += b * work.first[k],
            }
        }
    }

    /// Adds `weight` times the lower triangle of the Hessian: forward over reverse, one sweep for each
    /// variable.
    pub(crate) fn add_hessian(
        &self,
        x: &[f64],
        weight: f64,
        work: &mut Work,
        hessian: &mut dyn FnMut(usize, usize, f64),
    ) {
        self.add_gradient(x, weight, work, &mut |_, _| {});
        let n = self.nodes.len();
        for &j in &self.variables {
            for (k, node) in self.nodes.iter().enumerate() {
                work.tangent[k] = match *node {
                    Node::Constant(_) => 0.0,
                    Node::Variable(i) => f64::from(u8::from(i == j)),
                    Node::Sum(a, b) => work.tangent[a] + work.tangent[b],
                    Node::Product(a, b) => {
                        work.tangent[a] * work.value[b] + work.value[a] * work.tangent[b]
                    }
                    Node::Unary(_, a) => work.first[k] * work.tangent[a],
                };
            }
            work.bar_tangent[..n].fill(0.0);
            for (k, node) in self.nodes.iter().enumerate().rev() {
                let (b, t) = (work.bar[k], work.bar_tangent[k]);
                match *node {
                    Node::Constant(_) => {}
                    Node::Variable(i) => {
                        if i >= j && t != 0.0 {
                            hessian(i, j, t);
                        }
                    }
                    Node::Sum(p, q) => {
                        work.bar_tangent[p] += t;
                        work.bar_tangent[q] += t;
                    }
                    Node::Product(p, q) => {
                        work.bar_tangent[p] += t * work.value[q] + b * work.tangent[q];
                        work.bar_tangent[q] += t * work.value[p] + b * work.tangent[p];
                    }
                    Node::Unary(_, a) => {
                        work.bar_tangent[a] +=
                            t * work.first[k] + b * work.second[k] * work.tangent[a];
                    }
                }
            }
        }
    }

    fn forward(&self, x: &[f64], work: &mut Work) {
        work.reserve(self.nodes.len());
        for (k, node) in self.nodes.iter().enumerate() {
            work.value[k] = match *node {
                Node::Constant(c) => c,
                Node::Variable(i) => x[i],
                Node::Sum(a, b) => work.value[a] + work.value[b],
                Node::Product(a, b) => work.value[a] * work.value[b],
                Node::Unary(f, a) => {
                    let (value, first, second) = f.evaluate(work.value[a]);
                    work.first[k] = first;
                    work.second[k] = second;
                    value
                }
            };
        }
    }
}

/// Memory of the sweeps, shared by all expressions of a problem.
#[derive(Debug, Clone, Default)]
pub(crate) struct Work {
    value: Vec<f64>,
    first: Vec<f64>,
    second: Vec<f64>,
    tangent: Vec<f64>,
    bar: Vec<f64>,
    bar_tangent: Vec<f64>,
}

impl Work {
    fn reserve(&mut self, nodes: usize) {
        if self.value.len() < nodes {
            for array in [
                &mut self.value,
                &mut self.first,
                &mut self.second,
                &mut self.tangent,
                &mut self.bar,
                &mut self.bar_tangent,
            ] {
                array.resize(nodes, 0.0);
            }
        }
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
        let function = if exponent.fract() == 0.0 && exponent.abs() < 100.0 {
            Function::Power(exponent as i32)
        } else {
            Function::RealPower(exponent)
        };
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
        let function = match name {
            "exp" => Function::Exponential,
            "log" => Function::Logarithm,
            "sqrt" => Function::SquareRoot,
            "sin" => Function::Sine,
            "cos" => Function::Cosine,
            "atan" => Function::ArcTangent,
            "tanh" => Function::HyperbolicTangent,
            _ => panic!("unknown name `{name}` at byte {start}"),
        };
        assert!(self.take(b'('), "missing bracket after {name}");
        let argument = self.sum();
        assert!(self.take(b')'), "missing bracket after {name}");
        self.push(Node::Unary(function, argument))
    }
}
