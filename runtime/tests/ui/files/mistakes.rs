hangtime::model_file!("../../../tmp/ball.hang");

fn main() {
    let _ = Ball::default();
}
