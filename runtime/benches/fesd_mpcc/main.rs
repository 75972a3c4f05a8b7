fn main() {
    lab::main()
}
mod lab;
mod scenes;
