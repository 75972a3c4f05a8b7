fn main() { lab::main() }
mod scenes;
mod lab;
