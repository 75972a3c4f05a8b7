hangtime::model_file!("scenes/ball.hang");

fn main() {
    let _ = Ball::default();
}
