//! Scenes declared where every name that emitted code could need means something else.

#![allow(deprecated, reason = "warned of: a floor that nothing touches")]

#[allow(dead_code, non_camel_case_types, non_upper_case_globals)]
mod hostile {
    mod hangtime {}
    mod std {}
    mod core {}
    struct f64;
    struct f32;
    struct u32;
    struct usize;
    struct bool;
    struct Vec;
    struct Box;
    struct Some;
    struct None;
    trait Default {}
    trait Clone {}
    trait Debug {}
    trait PartialEq {}
    trait Copy {}
    trait Iterator {}
    trait From {}

    // Where a constant is in scope, a local variable of its name is a pattern that tests for its value.
    macro_rules! constants {
        ($($name:ident)+) => { $(const $name: i8 = 1;)+ };
    }
    constants!(a b c d e f i m n p q s t u v w x y z e0 e1 e2 e3 e4 out index value values point contact lower upper);
    constants!(energy multipliers constant t0 t1 t2 t3 t4 t5 t6 t7 t8 t9 t10 t11 t12 t13 t14 t15 t20 t30 t40);

    ::hangtime::model! {
        pub Option {
            parameters { m: kg = 2, g: m/s^2 = 9.81, e = 0.5, mu = 0.3 }
            coordinates { y: m, z: m }
            controls { u: N in -1..=1 }
            lagrangian m/2*|dot((y, z))|^2 - m*g*z
            forces { y: u }
            surface ground: z >= 0
            impact ground: restitution e, friction mu
            start { z: 1 [m] }
            horizon 1 [s]
            minimize time + integral(u^2)/1 [N^2]
            finally { y == 1 [m] }
            free { dot(y) in 0..=3 }
        }
    }

    ::hangtime::model! {
        // Solved with at run time.
        pub Ring {
            parameters { k = 3, gen = 2 }
            coordinates { a, b, c, d, e, f, g, h, i, j }
            let p = (sin(a) + sin(b) + sin(c) + sin(d) + sin(e), cos(f) + cos(g) + cos(h) + cos(i) + cos(j))
            lagrangian |dot((a, b, c, d, e, f, g, h, i, j))|^2 + gen*|dot(p)|^2 - k*p.z
            surface floor: p.z >= -30
            impact floor: inelastic
        }
    }
}

#[allow(non_camel_case_types)]
mod named {
    ::hangtime::model! { pub Copy { coordinates { z } lagrangian dot(z)^2/2 - 5*z } }
    ::hangtime::model! { pub hangtime { coordinates { z } lagrangian dot(z)^2/2 - 6*z } }
    ::hangtime::model! { pub gen { parameters { gen = 7 } coordinates { z } lagrangian dot(z)^2/2 - gen*z } }
}

/// What a macro hands over is one expression.
macro_rules! falling {
    ($name:ident, $force:expr, $power:expr, $unit:ty, $least:literal) => {
        hangtime::model! {
            pub(crate) $name {
                parameters { m: $unit = 1, w: N = 1 }
                coordinates { z: m in $least..=9 }
                lagrangian m/2*dot(z)^2 - 3*$force*w*z - $power^2*w*z
            }
        }
    };
}
falling!(Thrown, 2 + 5, -4, kg, -1);

fn acceleration(model: &dyn hangtime::model::Model) -> f64 {
    let mut a = [0.0];
    model.free_acceleration(&[0.4, 0.0], &mut a);
    a[0]
}

#[test]
fn scenes_mean_the_same_whatever_names_are_in_scope() {
    assert_eq!(acceleration(&named::Copy::default()), -5.0);
    assert_eq!(acceleration(&named::hangtime::default()), -6.0);
    assert_eq!(acceleration(&named::r#gen { r#gen: 8.0 }), -8.0);
    assert_eq!(acceleration(&named::r#gen::default().with_gen(9.0)), -9.0);
    assert_eq!(
        acceleration(&Thrown::default()),
        -f64::from(3 * (2 + 5) + (-4) * (-4))
    );
    assert_eq!(hostile::Option::default().m, 2.0);
    assert_eq!(hostile::Ring::default().r#gen, 2.0);
}
