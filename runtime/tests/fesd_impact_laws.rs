//! Restitution and friction in the finite element simulator, against closed forms.

mod common;
mod rough;

use common::{distance, last, start};
use hangtime::model::Model;
use hangtime::rk::Scheme;
use hangtime::simulation::{EventKind, Fesd, Simulation, SimulationStatus, Simulator};
use rough::{HandWritten, Number, Scene};

const GRAVITY: f64 = 9.81;

fn accurate() -> Fesd {
    Fesd::default()
        .with_scheme(Scheme::RadauIia, 5)
        .with_grid(40, 2)
}

/// A mass on an incline that falls towards positive `y`.
#[derive(Debug, Clone)]
struct Block {
    mass: f64,
    slope: f64,
    friction: f64,
    restitution: f64,
}

impl Scene<2, 1> for Block {
    fn coordinates(&self) -> [&'static str; 2] {
        ["y", "z"]
    }
    fn contacts(&self) -> &'static [&'static str] {
        &["incline"]
    }
    fn mass<D: Number>(&self, _q: &[D; 2]) -> [[D; 2]; 2] {
        let m = D::from(self.mass);
        let o = D::from(0.0);
        [[m, o], [o, m]]
    }
    fn force<D: Number>(&self, _q: &[D; 2], _v: &[D; 2], u: &[D; 1]) -> [D; 2] {
        [u[0], D::from(-GRAVITY * self.mass)]
    }
    fn potential(&self, q: &[f64; 2]) -> f64 {
        self.mass * GRAVITY * q[1]
    }
    fn gap<D: Number>(&self, _contact: usize, q: &[D; 2]) -> D {
        q[0] * self.slope.sin() + q[1] * self.slope.cos()
    }
    fn restitution(&self, _contact: usize) -> f64 {
        self.restitution
    }
    fn friction(&self, _contact: usize) -> f64 {
        self.friction
    }
    fn sliding<D: Number>(&self, _contact: usize, _q: &[D; 2], v: &[D; 2]) -> D {
        v[0] * self.slope.cos() - v[1] * self.slope.sin()
    }
}

fn simulate(simulator: &Fesd, model: &dyn Model, q: &[f64], v: &[f64], horizon: f64) -> Simulation {
    let n_u = model.declaration().controls.len();
    let mut problem = start(q, v, horizon);
    if n_u > 0 {
        problem.controls = hangtime::simulation::ControlSignal::Zero;
    }
    simulator
        .simulate(model, &problem, &mut |_| {})
        .expect("the problem is accepted")
}

/// `(angle, mu, v_0, t_stop, s_stop, friction force per mass sliding, stuck)`: closed form, 20 digits.
const BLOCKS: [(f64, f64, f64, f64, f64, f64, f64); 3] = [
    (
        15.0,
        0.5,
        3.0,
        1.3643487114989731386,
        2.0465230672484597078,
        -4.7378661779478799465,
        -2.5390148324557286786,
    ),
    (
        25.0,
        0.6,
        2.0,
        1.6825917146443121914,
        1.6825917146443121914,
        -5.3345276344977216836,
        -4.145885147676261469,
    ),
    (
        0.0,
        0.3,
        2.0,
        0.67957866123003737683,
        0.67957866123003737683,
        -2.943,
        0.0,
    ),
];

#[test]
fn block_on_incline_slides_stops_and_stays_as_in_closed_form() {
    for (angle, mu, speed, t_stop, s_stop, sliding, stuck) in BLOCKS {
        for mass in [1.0, 3.0] {
            let slope = f64::to_radians(angle);
            let model = HandWritten::new(Block {
                mass,
                slope,
                friction: mu,
                restitution: 0.0,
            });
            let simulation = simulate(
                &Fesd::default(),
                &model,
                &[0.0, 0.0],
                &[speed * slope.cos(), -speed * slope.sin()],
                3.0,
            );
            assert_eq!(simulation.status, SimulationStatus::Solved);
            let [stop] = &simulation.events[..] else {
                panic!("{:?}", simulation.events)
            };
            assert_eq!(stop.kind, EventKind::Stick);
            assert!((stop.time - t_stop).abs() < 1e-14, "{}", stop.time - t_stop);
            let (q, v) = last(&simulation.trajectory);
            let at = [s_stop * slope.cos(), -s_stop * slope.sin()];
            assert!(distance(q, &at) < 1e-14, "{q:?} {at:?}");
            assert!(distance(v, &[0.0, 0.0]) < 1e-15);
            let trajectory = &simulation.trajectory;
            let first = trajectory.friction_force[0][0];
            assert!((first - mass * sliding).abs() < 1e-13);
            let rest = trajectory.friction_force.last().expect("recorded")[0];
            assert!((rest - mass * stuck).abs() < 1e-13);
            assert!(simulation.residuals.dual < 1e-13);
            assert!(simulation.residuals.primal < 1e-13);
        }
    }
}

#[test]
fn ball_with_restitution_follows_the_closed_form() {
    let height: f64 = 1.0;
    for e in [0.3, 0.5, 0.9, 1.0] {
        let model = HandWritten::new(Block {
            mass: 2.0,
            slope: 0.0,
            friction: 0.0,
            restitution: e,
        });
        let simulation = simulate(&accurate(), &model, &[0.0, height], &[1.0, 0.0], 6.0);
        assert_eq!(simulation.status, SimulationStatus::Solved, "{e}");
        let fall = (2.0 * height / GRAVITY).sqrt();
        let mut time = fall;
        let mut speed = GRAVITY * fall;
        let impacts: Vec<_> = simulation
            .events
            .iter()
            .filter(|event| event.kind == EventKind::Impact)
            .collect();
        println!("{e}: {} {:?}", impacts.len(), simulation.notes);
        for impact in impacts {
            assert!((impact.time - time).abs() < 1e-8, "{} {time}", impact.time);
            speed *= e;
            time += 2.0 * speed / GRAVITY;
        }
    }
}
