//! Scenes to choose from, one file each in `gallery/`: what each asks, and the answer that it gives by default.
//!
//! Switched systems that nothing steers and mechanisms of textbooks ask nothing: they are simulated, and their tests have their closed forms.
//!
//! Answers are what `hangtime solve SCENE` says, of 2026-12-01. Objectives are the least ones known on so many control intervals, as
//! `hangtime solve SCENE --intervals N` finds them: to 1e-6 but for `hop-forward`, `rolling-bike`, `two-wheels` and `two-bumps`, where it
//! may end 1.2, 0.7, 0.15 and 0.14 % above them.

use hangtime_cli::{Question, Scene};

macro_rules! gallery {
    ($($group:literal { $($name:literal: $title:literal $(, $asked:literal => $answer:literal ($intervals:literal: $best:literal))?;)* })*) => {
        &[$($(
            Scene::unread($name, $title, include_str!(concat!("../gallery/", $name, ".hang")))
                .in_group($group)
                .pictured(include_str!(concat!("../pictures/", $name, ".svg")))
                $(.asking(Question { asked: $asked, answer: $answer, known: ($intervals, $best) }))?,
        )*)*]
    };
}

/// All scenes of the gallery.
pub(crate) const GALLERY: &[Scene] = gallery! {
    "publication" {
        "ski-jump-pushed": "a ski jumper with legs pushes off, against the air",
            "How far away are they after five seconds?" => "71.5 m, with a start of 3.07 m/s that is counted as 9.4 m." (10: -57.417259363219);
    }
    "flights and bounces" {
        "wall-ball": "a ball is played off a wall and comes back to the hand",
            "With how little effort does it come back?" => "12.48 N^2 s; the wall gives back what it needs." (10: 13.007342179766);
        "juggler": "a paddle keeps a ball in the air for two seconds",
            "With how little effort are paddle and ball as they were?" => "35.86 N^2 s." (10: 39.377291163);
        "catch": "a hand catches a falling ball and brings it to rest",
            "With how little effort?" => "35.82 N^2 s, the hand goes along with the ball." (10: 35.885420348);
    }
    "friction" {
        "rough-block": "a block on a rough floor is pushed from rest to rest",
            "Is it better to push all the time, or to let it slide?" => "16.01 N^2 s: it is pushed for a while, and slides the rest of the way by itself." (10: 16.109644905);
        "plate-and-box": "a box slips on a driven plate to its place",
            "How soon can it be there?" => "In 1.82 s, with an effort that counts like 1 ms for each N^2 s." (10: 1.820078283);
        "pushing": "a finger pushes a box to its place and comes back",
            "With how little effort?" => "11.74 N^2 s: it lets go after a second, and friction brakes the box." (10: 12.086862391881);
    }
    "vehicles" {
        "two-bumps": "a bike and its rider cross two bumps in least time",
            "How soon are they across?" => "In 1.331 s." (10: 1.397362919);
        "two-wheels": "a rigid bike on two wheels crosses waves in least time",
            "How soon is it across?" => "In 0.904 s." (10: 0.904453159);
        "measured-track": "a bike and its rider cross three bumps of a measured track in least time",
            "How soon are they across?" => "In 1.870 s, with a jump over each." (15: 1.883964422163);
        "gap-jump": "a bike and its rider jump over a gap",
            "How slow may they come?" => "At 5.57 m/s, if the legs push off at the end of the ramp." (10: 5.934758836622);
        "rolling-bike": "a bike rolls on two tyres by friction, its rider leans and pushes",
            "How soon does it cross a wave of a pump track?" => "In 0.706 s." (10: 0.709273689);
        "spinning-wheel": "a driven wheel goes five metres from rest to rest",
            "How soon, where too much torque spins it?" => "In 2.258 s." (10: 2.257618205);
    }
    "legs" {
        "hop": "a body on a massive foot hops from flat ground",
            "With how little effort does the foot rise by 0.3 m?" => "33.84 N^2 s." (10: 41.67526238);
        "hopper": "two masses on a spring hop on the spot for ever",
            "With how little effort of its motor?" => "1.710 N^2 s a hop: it gives back what the landing takes." (10: 2.177154493);
        "hop-forward": "a body on a springy leg hops forward on rough ground",
            "With how little effort does it hop a metre?" => "9.839 N^2 s." (10: 10.640004796);
        "biped": "a body on two legs walks half a metre on rough ground",
            "With how little effort does it walk?" => "4.882 N^2 s beyond what carries the body." (10: 5.148088311);
        "gymnast": "a gymnast on a high bar swings up by the hips",
            "How high can the legs be after two and a half seconds?" => "1.75 m, which is a handstand." (10: -1.741648439162);
        "push-off": "a ski jumper pushes off with the legs",
            "How far away are they after two and a half seconds?" => "15.00 m, with an effort that counts like a centimetre for each 1000 N^2 s." (10: -14.706644549492);
    }
    "machines" {
        "lander": "a lander with a sprung leg touches down on the Moon",
            "With how little thrust does it land and stay?" => "0.832 N s." (10: 0.953743432);
        "crane": "a crane between two walls swings its load beyond them",
            "With how little effort?" => "14.99 N^2 s." (10: 15.209649911);
        "cart-pole": "a pole on a cart between two walls is swung up",
            "With how little effort, if the walls may be used?" => "40.32 N^2 s." (10: 47.872349491);
        "pendulum-with-stop": "a pendulum with a weak motor and a stop is swung up",
            "With how little effort?" => "25.13 N^2 m^2 s." (10: 27.785882879);
    }
    "games" {
        "billiards": "a ball is pocketed by way of a cushion",
            "Which shot needs the least speed?" => "One of 1.09 m/s, by (0.71, -0.83) m/s." (1: 1.198147935948);
        "curling": "a curling stone has to come to rest in the house",
            "With how little effort of a hand that stays behind a line?" => "1156.1 N^2 s." (10: 1180.669452634);
        "cradle-of-carts": "a driven cart sets two others in motion, one by the other",
            "With how little effort?" => "2.237 N^2 s." (10: 2.390910722);
    }
    "estimation" {
        "bouncing-throw": "a ball that was filmed bounces along a rough floor",
            "How much does it bounce, and how much does the floor rub?" => "e = 0.778 and mu = 0.120, each to a thousandth." (0: 36.094042503588);
        "jump-on-sledge": "a rider was filmed who jumped on a sledge",
            "What does the rider weigh?" => "69 kg, to 2 kg." (0: 54.680407866219);
    }
    "switched systems" {
        "crossing": "a motion crosses a jump of its rate";
        "sliding": "a motion slides along a jump of its rate";
        "leaving-sliding": "a motion slides along a jump until what pushes it away is stronger";
        "unstable-sliding": "a motion that may leave a jump to both sides";
        "spiral": "the oscillator that turns the other way outside of the unit circle";
        "relay": "a relay pushes back with the same force wherever its load is";
        "two-relays": "two relays slide at once";
        "two-genes": "two genes switch each other";
        "tank-cascade": "a tank runs over into a second one";
        "thermostat": "a thermostat with two temperatures";
        "gear-shift": "a car shifts at two speeds";
        "turbo-car": "a car with a turbo goes 200 m from rest to rest",
            "How soon is it there?" => "In 11.82 s; in 11.8 s where the controls may change every fifth of a second." (10: 12.0165872356);
        "hysteresis-car": "a car with a turbo that remembers goes 150 m from rest to rest",
            "How soon is it there?" => "In 10.14 s; in 10.13 s where the controls may change at any time." (10: 10.2292579113);
        "voice-coil": "a coil moves a load on a spring by a centimetre, against dry friction",
            "With how little voltage?" => "1.180 V^2 s on 15 intervals, 0.856 on 30." (15: 1.1796425117);
        "race-car": "a car drifts along a winding track",
            "How soon is it 5 m further on?" => "In 2.357 s, drifting five times." (12: 2.3581865465);
        "slide-to-target": "a relay holds one state while the other one goes to its target",
            "With how little effort?" => "0.5 s." (10: 0.5);
        "passing-relay": "a relay that holds back has to be passed",
            "With how little effort?" => "4 s: wait in it, and push at the end." (6: 4.0);
    }
    "mechanisms of textbooks" {
        "chain-of-links": "a chain of links swings from the wall";
        "newtons-cradle": "Newton's cradle: the last ball swings out as far as the first one came";
        "bead-chain": "beads on threads are thrown: the threads go slack, and jerk";
        "billiard-break": "the break: a ball strikes fifteen others";
        "galton-board": "Galton's board: balls fall through rows of pins";
        "dominoes": "dominoes fall, one over the other";
        "brick-wall": "the upper brick of a wall is knocked off";
        "toppling-bricks": "a stack of bricks leans over the edge of a table too far, and topples";
        "plank-bridge": "a ball falls on a bridge of planks";
        "seesaw": "a box falls on a seesaw, and lifts another one";
        "trebuchet": "a trebuchet throws a stone";
        "four-bar": "Hoecken's four-bar linkage: a point of its coupler draws a straight line";
        "wiper": "a windscreen wiper: a motor turns a crank, and two arms swing in step";
        "jansens-linkage": "Theo Jansen's linkage: a leg of eleven rods walks as its crank turns";
        "two-legs": "a biped of two equal legs falls on its feet";
        "chain-on-pulley": "a chain slides off a pulley";
        "ball-bearing": "a ball bearing is started: its balls slip, and roll";
        "tracked-vehicle": "a tracked vehicle starts: its track slips, then grips";
        "car": "a car brakes on its two wheels, and dives";
        "gripper": "a gripper lifts a box, until it slips through its fingers";
        "clock": "a clock: the wheel of an escapement goes on by half a tooth at each swing of the pendulum";
        "geneva-drive": "a Geneva drive: a pin turns a wheel by a quarter, and lets it rest for three";
        "dice": "a die is thrown, falls from corner to corner, and comes to rest on a face";
        "tippe-top": "a tippe top is spun on a table, and turns upside down";
    }
};
