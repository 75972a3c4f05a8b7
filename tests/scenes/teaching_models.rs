//! The examples that are scenes with a motion; their closed forms stand in `tests/cases`.

#[expect(dead_code, reason = "the example is a program with a main function")]
#[path = "../../examples/ball_on_slope.rs"]
pub(crate) mod ball_on_slope;

#[expect(dead_code, reason = "the example is a program with a main function")]
#[path = "../../examples/block_on_incline.rs"]
pub(crate) mod block_on_incline;

#[expect(dead_code, reason = "the example is a program with a main function")]
#[path = "../../examples/bouncing_ball.rs"]
pub(crate) mod bouncing_ball;

#[expect(dead_code, reason = "the example is a program with a main function")]
#[path = "../../examples/double_pendulum_with_stop.rs"]
pub(crate) mod double_pendulum_with_stop;

#[expect(dead_code, reason = "the example is a program with a main function")]
#[path = "../../examples/elastic_ball_in_box.rs"]
pub(crate) mod elastic_ball_in_box;

#[expect(dead_code, reason = "the example is a program with a main function")]
#[path = "../../examples/pendulum_against_wall.rs"]
pub(crate) mod pendulum_against_wall;
