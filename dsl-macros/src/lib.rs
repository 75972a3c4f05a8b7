//! The `model!` macro: a thin shell over [`hangtime_dsl`].

/// Declares a mechanical scene and derives everything that the solvers need from it.
///
/// A scene is written as in a textbook: coordinates, a Lagrangian, surfaces, impact laws. From it the
/// macro derives, at compile time and by dual numbers, the mass matrix, the free acceleration, and for
/// each surface its gap, normal velocity and contact direction, all with sparse Jacobians and Hessians,
/// and emits them as straight-line Rust. The scene becomes a struct whose fields are the parameters and
/// which implements `hangtime::model::Model`; its documentation lists what was derived.
///
/// ```
/// use hangtime::model::{Model, contact_point};
///
/// hangtime::model! {
///     /// A ball above a slope.
///     pub Ball {
///         parameters  { m: kg = 0.2, g: m/s^2 = 9.81, slope = 0.5, height: m = 2 }
///         coordinates { y: m, z: m }
///         let p = (y, z)
///         lagrangian  m/2*|dot(p)|^2 - m*g*p.z
///         surface     ground: z >= -slope*y
///         impact      ground: inelastic
///         start       { z: height, dot(y): 1 }
///         horizon     3 [s]
///     }
/// }
///
/// let ball = Ball { slope: 0.75, ..Default::default() }.with_height(3.0);
/// let mut acceleration = [0.0; 2];
/// ball.free_acceleration(&[0.0, 3.0, 1.0, 0.0], &mut acceleration);
/// assert_eq!(acceleration, [0.0, -9.81]);
/// let mut point = [0.0; contact_point::length(2)];
/// ball.contact(0, &[0.0, 3.0, 1.0, 0.0], &mut point);
/// assert_eq!(point[contact_point::NORMAL_VELOCITY], 0.75);
/// ```
///
/// # Grammar
///
/// ```text
/// scene       = doc-comments ["pub"] Name "{" statement* "}"
/// statement   = "parameters"  "{" (name [":" unit] "=" number),* "}"
///             | "coordinates" "{" (name [":" unit] ["in" expr "..=" expr]),* "}"
///             | "controls"    "{" (name [":" unit] ["in" expr "..=" expr]),* "}"
///             | "let" name "=" expr
///             | "fn" name "(" name,* ")" "=" expr
///             | "lagrangian" expr
///             | "dissipation" expr
///             | "forces" "{" (name ":" expr),* "}"
///             | "surface" name ":" expr (">=" | "<=") expr
///             | "impact" name,* ":" part,*
///             | "start" "{" (target ":" expr),* "}"
///             | "horizon" expr
///             | "minimize" expr
///             | "constraint" name ":" condition
///             | "finally" "{" condition,* "}"
///             | "free" "{" (target ["in" expr "..=" expr]),* "}"
/// part        = "inelastic" | "restitution" expr | "friction" expr | "sliding" expr
///             | "along" expr | "holding" name,*
/// condition   = expr ("==" | ">=" | "<=") expr
/// target      = name | "dot" "(" name ")"
/// expr        = expr ("+" | "-") expr | expr ("*" | "/") expr | "-" expr | expr "^" expr
///             | number ["[" unit "]"] | name | name "(" expr,* ")" | "(" expr,* ")" | "|" expr "|"
///             | expr "." name | expr "." "(" expr ")" | expr "[" number "]" | "diff" "(" name ")" "(" expr ")"
/// unit        = symbols, powers "^", products by blank or "*", quotients "/", parentheses, "1"
/// ```
///
/// Operators bind as on paper: `+ -` weakest, then `* /`, then the sign, then `^` (so `-y^2` is
/// `-(y^2)`). A product needs its `*`; two powers in a row need parentheses. Doc comments on the scene,
/// on parameters, coordinates, controls, surfaces, constraints and terminal conditions are carried to the
/// struct and to `hangtime::model::Declaration`.
///
/// # Statements
///
/// **`parameters`** are numbers that can change at run time: fields of the struct with a default, and
/// setters `with_name`. Nothing is recompiled for another value. **`coordinates`** are the generalized
/// coordinates `q`, in the order of `q` and `v` everywhere; **`controls`** are the inputs `u`. Both may
/// have bounds, which may depend on parameters; a unit behind the upper one is meant for both:
/// `l: m in 30..=50 [cm]`.
///
/// **`let`** abbreviates an expression and **`fn`** declares a function; both are inserted where they
/// are used, at no cost. They stand above their first use.
///
/// **`lagrangian`** is kinetic minus potential energy, `L(q, v, t)`, quadratic in the velocities. The
/// velocity of anything is `dot(...)`, its total time derivative. With `Q` the forces, the equations of
/// motion are
///
/// ```text
/// M(q) a = dL/dq + Q - (d2L/dv dq) v - d2L/dv dt,          M = d2L/dv2
/// ```
///
/// **`forces`** are generalized forces `Q`, one for each coordinate that has one; they may depend on
/// everything and several statements add up. **`dissipation`** is Rayleigh's function `R(q, v)`, and
/// adds `-dR/dv`.
///
/// ```
/// hangtime::model! {
///     /// A pendulum with a motor in its joint and a damper.
///     pub Pendulum {
///         parameters  { m: kg = 1, l: m = 0.5, g: m/s^2 = 9.81, c: N m s = 0.1 }
///         coordinates { theta: rad }
///         controls    { torque: N m in -2..=2 }
///         let bob = l*(sin(theta), -cos(theta))
///         lagrangian  m/2*|dot(bob)|^2 - m*g*bob.z
///         dissipation c/2*dot(theta)^2
///         forces      { theta: torque }
///     }
/// }
/// # use hangtime::model::Model;
/// let mut acceleration = [0.0];
/// // At rest in the lowest position only the motor acts: torque / (m l^2).
/// Pendulum::default().free_acceleration(&[0.0, 0.0, 1.0], &mut acceleration);
/// assert_eq!(acceleration, [4.0]);
/// ```
///
/// **`surface`** bounds the motion: its gap `g = left - right` (or `right - left` for `<=`) stays at or
/// above zero. It depends on coordinates, and possibly on parameters and the time `t`. **`impact`** gives
/// the law of one or several surfaces: its parts, in any order, are described under
/// [Impact laws](#impact-laws).
///
/// ```
/// hangtime::model! {
///     /// Bike and rider: two point masses on a massless link, on a track.
///     pub PumpTrack {
///         parameters  { m_b: kg = 15, m_r: kg = 75, g: m/s^2 = 9.81, a: m = 0.2, k: 1/m = 2 }
///         coordinates { y: m, s: m, l: m in 0.27803..=0.59559 }
///         controls    { u: N in -108.25..=376.875 }
///         fn track(y) = a*(1 - cos(k*y))
///         let bike  = (y, track(y) + s)
///         let rider = (y, track(y) + s + l)
///         lagrangian  m_b/2*|dot(bike)|^2 + m_r/2*|dot(rider)|^2 - m_b*g*bike.z - m_r*g*rider.z
///         forces      { l: u }
///         surface     ground: s >= 0
///         impact      ground: inelastic, along (-diff(track)(y), 1, 0)
///     }
/// }
/// # use hangtime::model::Model;
/// let scene = PumpTrack::default();
/// // In flight the link force acts between the masses: l'' = u/m_b + u/m_r.
/// let mut a = [0.0; 3];
/// scene.free_acceleration(&[0.3, 0.1, 0.4, 2.0, 0.0, 0.0, 30.0], &mut a);
/// assert_eq!((a[0], (a[2] - 2.4).abs() < 1e-15), (0.0, true));
/// ```
///
/// **`start`** gives initial coordinates and velocities, as expressions of parameters; what is left out
/// is zero. **`horizon`** is the length of a simulation in seconds.
///
/// ```
/// hangtime::model! {
///     /// A sledge on a hill: it starts at rest on the surface, wherever `start_y` is.
///     pub Sledge {
///         parameters  { m: kg = 50, g: m/s^2 = 9.81, start_y: m = -1 }
///         coordinates { y: m, z: m }
///         fn hill(y)  = 0.3 [1/m]*y^2
///         lagrangian  m/2*|dot((y, z))|^2 - m*g*z
///         surface     snow: z >= hill(y)
///         impact      snow: inelastic
///         start       { y: start_y, z: hill(start_y), dot(y): 3.6 [km/h] }
///         horizon     2 [s]
///     }
/// }
/// # use hangtime::model::Model;
/// let (mut q, mut v) = ([0.0; 2], [0.0; 2]);
/// Sledge::default().with_start_y(2.0).start(&mut q, &mut v);
/// assert!((q[1] - 1.2).abs() < 1e-15 && (v[0] - 1.0).abs() < 1e-15);
/// ```
///
/// **`minimize`** is the objective of optimal control, a sum. Terms `integral(e)`, possibly times constants,
/// are the running cost: `e` is a function of coordinates, velocities, controls and the time `t`, integrated
/// over physical time, which stands still during impacts. All other terms are the final cost, a function of
/// coordinates and velocities at the end and of the final time `time`. **`finally`** lists conditions at the
/// end, of the same quantities. Where `time` occurs in either, the final time is to be found.
///
/// **`constraint`** names a condition that holds all the time, on coordinates, velocities, controls and `t`.
/// **`free`** lists initial coordinates and velocities that are to be found, possibly between bounds;
/// `start` gives their guess. Bounds of coordinates and controls belong to their declarations.
///
/// ```
/// hangtime::model! {
///     /// A cart that is to swing its load through a window, quickly and with little effort.
///     pub Crane {
///         parameters  { m: kg = 4, load: kg = 1, l: m = 0.8, g: m/s^2 = 9.81, effort: s/N^2 = 0.01 }
///         coordinates { y: m in -1..=3, theta: rad }
///         controls    { u: N in -20..=20 }
///         let hook = (y + l*sin(theta), -l*cos(theta))
///         lagrangian  m/2*dot(y)^2 + load/2*|dot(hook)|^2 - load*g*hook.z
///         forces      { y: u }
///         minimize    time + integral(effort*u^2)/1 [s]
///         /// The winch gives no more.
///         constraint  power: u*dot(y) <= 30 [W]
///         finally     { hook.y == 2 [m], hook.z >= -0.5 [m], time <= 4 [s] }
///         free        { y in -0.5..=0.5, theta }
///     }
/// }
/// # use hangtime::model::Model;
/// let crane = Crane::default();
/// let task = crane.declaration().optimal_control.unwrap();
/// assert!(task.running_cost && task.final_cost && task.free_time);
/// assert_eq!(task.free_start, [0, 1]);
/// // Running cost, then the constraint `30 W - u y'`; x = (y, theta, y', theta', u).
/// let mut values = [0.0; 2];
/// crane.path_functions(&[0.0, 0.0, 2.0, 0.0, 10.0], &mut values);
/// assert_eq!(values, [1.0, 10.0]);
/// // Final cost, then the three conditions; z = (y, theta, y', theta', time).
/// let mut values = [0.0; 4];
/// crane.terminal_functions(&[2.5, 0.0, 0.0, 0.0, 3.0], &mut values);
/// assert!((values[0], values[1], values[3]) == (3.0, 0.5, 1.0));
/// ```
///
/// # Impact laws
///
/// With the gap `g`, its normal `n = grad g`, the mass matrix `M` and `v_n = n'v`, an impact changes the
/// velocity along the *contact direction* `d`,
///
/// ```text
/// v+ = v- + d p,    d = w / (n'w),    w = H n,    H = M^-1,    D = n'H n
/// ```
///
/// and the force of a lasting contact acts along `d` as well. The parts of a law are
///
/// - `inelastic`: no rebound, `v_n+ = 0`, so `p = -v_n-`.
/// - `restitution e`: Newton's law, `v_n+ = -e v_n-`, so `p = -(1 + e) v_n-`. `e` is an expression of
///   parameters, at least 0 (`inelastic`) and at most 1 (no loss).
/// - `friction mu`: Coulomb's law in the plane. Besides the normal force `r d` there is a tangential one
///   `s e` along the *friction direction* `e = H b/D`, with `b = d v_t/dv` for the sliding velocity `v_t`:
///
///   ```text
///   |s| <= mu r,    s v_t = -mu r |v_t|
///   ```
///
///   so it brakes with `mu r` while the contact slides, and otherwise sticks with what it takes; so do the
///   impulses of an impact. `mu` is an expression of parameters, at least 0.
/// - `sliding v`: the sliding velocity, a sum of velocities times functions of positions that vanishes at
///   rest. Scale it like the gap: normal and tangential part of one velocity. It follows by itself for one
///   point mass in two Cartesian coordinates (`M` is a number times the identity) on a surface at rest, as
///   `v_t = n_z y' - n_y z'`: to the right on ground below.
/// - `along (w_1, ..)`: another direction `w`, one component a coordinate, in their order. Not together
///   with friction, whose normal force acts along `M^-1 n`.
/// - `holding q, ..`: coordinates that are rigid under the impulse, as a joint that is blocked or a link
///   whose force cannot change in an instant. `H` is then the inverse of the mass matrix of the system in
///   which they are locked, with zeros in their rows and columns.
///
/// Either `inelastic` or `restitution` must be there. Contacts that are touched together obey these laws
/// together (Moreau's law): all impulses at once, none of which pulls. Gaps must not be combinations of
/// each other.
///
/// ```
/// use hangtime::model::{Model, contact_point, tangent_point};
///
/// hangtime::model! {
///     /// A point mass in a tilted box: it rebounds from the walls and slides on the floor.
///     pub TiltedBox {
///         parameters  { m: kg = 1, g: m/s^2 = 9.81, e = 0.8, mu = 0.3, tilt = 0.75, width: m = 2 }
///         coordinates { y: m, z: m }
///         lagrangian  m/2*|dot((y, z))|^2 - m*g*z
///         surface     floor: z + tilt*y >= 0
///         surface     left: y >= 0
///         surface     right: y <= width
///         impact      floor: inelastic, friction mu
///         impact      left, right: restitution e, friction mu/2
///     }
/// }
/// let model = TiltedBox::default();
/// assert_eq!([0, 1].map(|contact| model.restitution(contact)), [0.0, 0.8]);
/// assert_eq!([0, 1].map(|contact| model.friction(contact)), [0.3, 0.15]);
/// // Normal (tilt, 1), so the tangent is (1, -tilt), as long as the normal.
/// let mut point = [0.0; tangent_point::length(2)];
/// model.tangent(0, &[1.0, 0.0, 2.0, -1.0], &mut point);
/// assert_eq!(point[tangent_point::SLIDING_VELOCITY], 2.75);
/// assert_eq!(point[tangent_point::TANGENT..][..2], [1.0, -0.75]);
///
/// hangtime::model! {
///     /// A rod that falls on its lower end, in a guide that holds its angle during impacts.
///     pub Rod {
///         parameters  { m: kg = 1, l: m = 1, g: m/s^2 = 9.81, mu = 0.5 }
///         coordinates { y: m, z: m, theta: rad }
///         let end = (y + l/2*sin(theta), z - l/2*cos(theta))
///         lagrangian  m/2*|dot((y, z))|^2 + m*l^2/24*dot(theta)^2 - m*g*z
///         surface     ground: end.z >= 0
///         impact      ground: restitution 0.5, holding theta, friction mu, sliding dot(end.y)
///     }
/// }
/// let mut point = [0.0; contact_point::length(3)];
/// Rod::default().contact(0, &[0.0, 1.0, 0.3, 0.0, -1.0, 0.0], &mut point);
/// // The locked rod takes the impulse as a point mass.
/// assert_eq!(point[contact_point::INVERSE_INERTIA], 1.0);
/// assert_eq!(point[contact_point::direction(3)..], [0.0, 1.0, 0.0]);
/// ```
///
/// # Expressions
///
/// Numbers, names, `pi`, and the physical time `t` \[s\]. Functions: `sin cos tan asin acos atan sinh cosh
/// tanh exp ln sqrt cbrt`, `atan2(y, x)`. `dot(e)` is the total time derivative of positions, `dot(a, b)`
/// or `a . b` the inner product, `cross(a, b)` the cross product, `|a|` the length of a vector. In
/// `minimize` and `finally` there are `time` and `integral(e)` besides.
/// `diff(f)(y)` is the derivative f'(y) of a function of one argument and `diff(diff(f))(y)` the second
/// one (an apostrophe behind a name is not a token of Rust).
///
/// Vectors are written `(a, b)`; those of two components are called (y, z), those of three (x, y, z):
/// `p.z`. Any component can be reached by its index from 0: `p[1]`.
///
/// Matrices are vectors of rows: `((a, b), (c, d))`. They multiply vectors and matrices on their right, `m*v`
/// and `m*n`, add up and have derivatives as vectors do; `m[0]` is a row, `m[0][1]` an entry. `rotation(phi)` turns
/// (y, z) from y to z; `rotation_x(phi)`, `rotation_y(phi)` and `rotation_z(phi)` turn (x, y, z) about an axis;
/// `transpose(m)` exchanges rows and columns, `diagonal(a, b, c)` has zeros elsewhere. In `a . (m*b)` any vector in
/// parentheses follows the point.
///
/// ```
/// hangtime::model! {
///     /// A heavy top on its tip: Euler angles, the angular velocity in the body, moments of inertia.
///     pub Top {
///         parameters  { m: kg = 0.4, l: m = 0.3, i_1: kg m^2 = 0.05, i_3: kg m^2 = 0.02, g: m/s^2 = 9.81 }
///         coordinates { psi: rad, theta: rad, phi: rad }
///         let r    = rotation_z(psi)*rotation_x(theta)*rotation_z(phi)
///         let w    = transpose(r)*dot(r)
///         let spin = (w[2][1], w[0][2], w[1][0])
///         lagrangian spin . (diagonal(i_1, i_1, i_3)*spin)/2 - m*g*l*(r*(0, 0, 1)).z
///     }
/// }
/// # use hangtime::model::Model;
/// // At rest, tilted by theta: i_1 theta'' = m g l sin(theta).
/// let mut a = [0.0; 3];
/// Top::default().free_acceleration(&[0.2, 0.5, 0.7, 0.0, 0.0, 0.0], &mut a);
/// assert!((a[1] - 0.4 * 9.81 * 0.3 * 0.5_f64.sin() / 0.05).abs() < 1e-12);
/// ```
///
/// ```
/// hangtime::model! {
///     /// A bead on a rotating parabola, in cylinder coordinates.
///     pub Bead {
///         parameters  { m: kg = 1, g: m/s^2 = 9.81, omega: 1/s = 2 }
///         coordinates { r: m }
///         fn height(r) = 0.5 [1/m]*r^2
///         let p = (r*cos(omega*t), r*sin(omega*t), height(r))
///         lagrangian  m/2*|dot(p)|^2 - m*g*p.z
///     }
/// }
/// # use hangtime::model::Model;
/// // (1 + h'^2) r'' = omega^2 r - g h' at rest; x = (r, r', t).
/// let mut a = [0.0];
/// Bead::default().free_acceleration(&[1.0, 0.0, 0.4], &mut a);
/// assert!((a[0] - (4.0 - 9.81) / 2.0).abs() < 1e-12);
/// ```
///
/// # Units
///
/// Each declaration may carry a unit, and so may each number in a formula, in brackets: `45 [m]`. Both
/// sides of sums, comparisons and declarations must agree; units that are not declared are inferred.
/// Numbers without a unit are pure numbers, except 0, which fits anywhere, and except in declarations,
/// where they are meant in the declared unit. Known are the SI units with prefixes, `N J W Pa bar Hz rad
/// deg rpm min h t L` and `km/h` and its like. Everything is computed in SI units; parameters,
/// coordinates and controls keep their declared unit at the interface. A scene that declares no units is
/// not checked.
///
/// # Mistakes
///
/// All mistakes are reported in one run, each at its place, with what to write instead. Those with a
/// code (`E01` to `E20`) have a page: `hangtime::model::explanation("E03")`, `hangtime explain E03`.
///
/// # An oracle
///
/// The scene also gets `lagrangian`, `generalized_forces` and `gaps`, generic over
/// `num_dual::DualNum` and written straight from the formulas: what is derived can be compared with dual
/// numbers at run time.
#[proc_macro]
pub fn model(input: proc_macro::TokenStream) -> proc_macro::TokenStream {
    hangtime_dsl::expand(input.into()).into()
}

/// The time at which a library that the current crate depends on was finished, as
/// `Option<f64>` [s since 1970]: `finished_at!(library_name)`.
///
/// It is read from the file that the compiler's arguments name (`--extern name=path`), and is `None`
/// if they name none or the compiler was given its arguments in a file.
#[doc(hidden)]
#[proc_macro]
pub fn finished_at(library: proc_macro::TokenStream) -> proc_macro::TokenStream {
    let prefix = format!("{library}=");
    let finished = std::env::args()
        .filter_map(|argument| {
            let path = argument.strip_prefix("--extern=").unwrap_or(&argument);
            path.strip_prefix(&prefix).map(std::path::PathBuf::from)
        })
        .find(|path| {
            path.extension()
                .is_some_and(|extension| extension == "rlib")
        })
        .and_then(|path| path.metadata().ok()?.modified().ok())
        .and_then(|modified| modified.duration_since(std::time::UNIX_EPOCH).ok());
    let text = match finished {
        Some(time) => format!("::core::option::Option::Some({:?}_f64)", time.as_secs_f64()),
        None => "::core::option::Option::None".to_owned(),
    };
    text.parse().unwrap_or_default()
}
