//! The constants that steer the search: what is looked for, in which order, and when it is enough.
//!
//! None of them decides what is true of a result. A motion is what its re-simulation says, an optimum what its multipliers and neighbours
//! say, whatever stands here; other values lead to other motions, or to the same with more work. Tolerances of the mathematics
//! (collocation, motions, judgement) stand where they are used.
//!
//! Units: *share of the motion* is of its final time, *relative* is to the size of the objective, *intervals* are those of the control grid;
//! what has no unit is a number or a count. Origins: *measured* with the figure, *follows* from something else, or *chosen*, where nothing
//! better than the order of magnitude is known. `cargo bench --bench zoo` tells what a change does.

/// What counts as equal, and as nothing, in all parts of the search.
pub(in crate::ocp) mod equal {
    /// Relative difference of the objective within which motions that were found by different programs are the same one, and below which a
    /// further search has led to nothing. Chosen: what discretizations and coarse tolerances change. Larger: optima are taken for
    /// one another; smaller: the same motion is looked at again.
    pub(in crate::ocp) const MOTION: f64 = 1e-3;
    /// The same of local optima of the same kind of program. Follows: a thousand tolerances of the programs (1e-9).
    pub(in crate::ocp) const OPTIMUM: f64 = 1e-6;
    /// The same of what an optimum costs, solved to its tolerance by different paths. Follows: a hundred of these tolerances.
    pub(in crate::ocp) const COST: f64 = 1e-7;
    /// What is rounding: of gaps and velocities of size one, of shares of the motion, of sums, and of objectives relative to their size; an
    /// objective that is better by more is better. Follows: a million roundings of numbers of size one, and the tolerance of the programs.
    pub(in crate::ocp) const ROUNDING: f64 = 1e-9;
    /// Switches within this share of the motion happen at one instant. Follows: what separates them is rounding and [`OPTIMUM`].
    pub(in crate::ocp) const INSTANT: f64 = 1e-6;
    /// Miss of a goal, in its size, that is none: [`super::off_grid::TOLERANCE`] of programs leaves as much. Chosen.
    pub(in crate::ocp) const MET: f64 = 1e-3;
}

/// Words to begin with, and the random motions that they are read from.
pub(in crate::ocp) mod beginnings {
    /// Motions under random controls that are drawn, and that are made of the best of them. Chosen.
    pub(in crate::ocp) const DRAWN: u64 = 100;
    pub(in crate::ocp) const CHANGED: usize = 200;
    /// Most times that words are looked for from other random motions, where none meets its goals. Measured: of troughs on 10 and 20 intervals
    /// one has its motion in the second turn.
    pub(in crate::ocp) const TURNS: u64 = 2;
    /// Best orders of events that become words, and those from which the library of cycles learns. Chosen.
    pub(in crate::ocp) const WORDS: usize = 8;
    pub(in crate::ocp) const LEARNED: usize = 24;
    /// Beginnings of motions that become words: of up to so many phases, so many of each length. Chosen; without them `brake-two-pads` of the
    /// families ends 0.4 % worse.
    pub(in crate::ocp) const PHASES: usize = 3;
    pub(in crate::ocp) const OF_EACH_LENGTH: usize = 2;
    /// Words of steps of feet that stand at the start, and the share of its part of the motion for which a foot stands before its step, and
    /// after it. Chosen: of one, and of two in turn, once and twice.
    pub(in crate::ocp) const STEPS: usize = 8;
    pub(in crate::ocp) const STEP: f64 = 0.25;
    /// Words in which a contact is visited, and the shares of the motion at which it closes and opens. Chosen.
    pub(in crate::ocp) const VISITS: usize = 8;
    pub(in crate::ocp) const VISIT: [f64; 2] = [0.4, 0.6];
    /// Simulated motions that time-freezing programs start from, the ride and the best random one. Measured: from a straight guess instead
    /// `two-bumps` ends 3.5 % worse.
    pub(in crate::ocp) const RELAXED: usize = 2;
    /// Motions under random controls among which one of a word is looked for, to solve it from once more. Chosen.
    pub(in crate::ocp) const TRIES: u64 = 16;
    /// Most instants of a cycle of the library. Chosen: a hop has two, a step and a slip three.
    pub(in crate::ocp) const LONGEST_CYCLE: usize = 3;
    /// Most phases of a word. Chosen: without a bound bounces that die out are words of any length.
    pub(in crate::ocp) const MOST_PHASES: usize = 16;
}

/// Programs of words: phases of free length.
pub(in crate::ocp) mod off_grid {
    /// Stages of the collocation. Chosen: order five.
    pub(in crate::ocp) const STAGES: usize = 3;
    /// Control pieces of a word for least time, which have lengths of their own, and of another, and the least number of a phase.
    /// Chosen: bang-bang controls need few of any length, others many of the same.
    pub(in crate::ocp) const FREE_PIECES: usize = 10;
    pub(in crate::ocp) const EVEN_PIECES: usize = 20;
    pub(in crate::ocp) const LEAST_PIECES: usize = 2;
    /// Least length of a phase to start with, a share of the motion: the program moves it from there. Chosen: at none a program starts
    /// on a bound.
    pub(in crate::ocp) const LEAST: f64 = 2e-3;
    /// Elements of a motion: controls that switch at any time use errors of longer ones. Chosen.
    pub(in crate::ocp) const ELEMENTS: f64 = 24.0;
    /// Excess over a whole number of elements that is let pass. Chosen: else lengths next to a whole number cost an element.
    pub(in crate::ocp) const ROUNDED: f64 = 0.3;
    /// By how much an element may become longer: what happens between the stages of longer ones is anybody's guess. Chosen.
    pub(in crate::ocp) const LONGEST: f64 = 1.5;
    /// Tolerance of a program of which the order of contacts is read; relative gain, and share of all presses, below which there is none.
    /// Chosen: words differ by more.
    pub(in crate::ocp) const TOLERANCE: f64 = 1e-4;
    /// First barrier parameter. Chosen: guesses are far from solutions.
    pub(in crate::ocp) const BARRIER: f64 = 1e-2;
    /// Most iterations. Measured: with 100 4 % of all iterations are saved, and 7 of 398 solved programs lost.
    pub(in crate::ocp) const ITERATIONS: usize = 150;
    /// Most iterations of the restoration phase, here and of the first program of a sequence. Measured: of 1014 that come to nothing 98 in
    /// 100 take some, mostly many; of 705 that are solved 29 take some, and four of these more than five.
    pub(in crate::ocp) const RESTORED: usize = 5;
    /// How often the range of final times of a word is moved at a time, by a factor of 20 at most. Chosen: on the grid it is moved on.
    pub(in crate::ocp) const MOVES: usize = 2;
    /// Least share of the unit of an objective that counts as its size. Chosen: smaller ones drown in rounding.
    pub(in crate::ocp) const LEAST_SHARE: f64 = 1e-6;
    /// Price of a miss to start with, in sizes of the objective per size of a goal, and by how much dearer it is for a word that would be
    /// the best. Chosen: too low a price lets words miss goals, too high a one hides the objective.
    pub(in crate::ocp) const PRICE: f64 = 10.0;
    pub(in crate::ocp) const DEARER: f64 = 100.0;
    /// By how much dearer at a time as long as no word meets its goals, how often it may bring a word no nearer, and the share of a miss
    /// that is no nearer. Measured: without it nine of 33 scenes of the zoo miss their goals in all words.
    pub(in crate::ocp) const UNMET: f64 = 1e3;
    pub(in crate::ocp) const IN_VAIN: usize = 2;
    pub(in crate::ocp) const NO_NEARER: f64 = 0.9;
    /// Most that a miss costs, in first prices. Chosen: of a dearer one rounding is left.
    pub(in crate::ocp) const DEAREST: f64 = 1e9;
    /// Where a word meets its goals, its objectives per size that a miss is made to cost, the least first, if it meets them still. Chosen:
    /// the objective decides among words, and not rounding of what is missed.
    pub(in crate::ocp) const CHEAPER: [f64; 2] = [1.0, 10.0];
}

/// The table of words, best first.
pub(in crate::ocp) mod table {
    /// Most drafts that are solved in a search, and drafts without a gain after which it ends. Chosen.
    pub(in crate::ocp) const DRAFTS: usize = 48;
    pub(in crate::ocp) const PATIENCE: usize = 15;
    /// Most guesses of one word; there is one more for each time that it was the best. Chosen: a program has local optima.
    pub(in crate::ocp) const GUESSES: usize = 3;
    /// Times of switches, shares of the motion, that differ by less are the same guess. Chosen.
    pub(in crate::ocp) const SAME_TIMES: f64 = 0.06;
    /// What a phase has to gain for a word to be better with it, relative: with more phases there are more control pieces. Chosen.
    pub(in crate::ocp) const WORTH_OF_PHASE: f64 = 1e-3;
    /// Prices, relative to the objective: of a further draft of the same rule, and of a phase. Chosen, with those of the rules.
    pub(in crate::ocp) const NEXT_OF_RULE: f64 = 0.015;
    pub(in crate::ocp) const OF_PHASE: f64 = 0.004;
    /// Fewest starts of the best word where initial values are free. Chosen.
    pub(in crate::ocp) const FREE_STARTS: usize = 8;
    /// Drafts of a rule and a parent after which every other rule has its turn, and the price of the next turn. Chosen; follows: the dearest
    /// of the rules.
    pub(in crate::ocp) const IN_A_TURN: usize = 2;
    pub(in crate::ocp) const NEXT_TURN: f64 = super::edits::price::CUT;
    /// Share of the parent's excess over the best that counts. Chosen: between the best alone and all alike.
    pub(in crate::ocp) const OF_PARENT: f64 = 0.5;
    /// Excess of a parent, relative, above which all are alike. Chosen: words that miss their goals are.
    pub(in crate::ocp) const MOST_EXCESS: f64 = 1e3;
    /// Relative excess over the best up to which a shorter word is followed. Chosen.
    pub(in crate::ocp) const SHORTER: f64 = 0.1;
    /// Words that are solved once more with pieces of free length, and by how much they may become worse, relative: other elements
    /// change as much. Chosen.
    pub(in crate::ocp) const REFINEMENTS: usize = 4;
    pub(in crate::ocp) const POORER: f64 = 2e-3;
    /// Words that may go on to the grid, of each at most so many motions, and the relative excess over the best up to which they are. Chosen.
    pub(in crate::ocp) const KEPT: usize = 12;
    pub(in crate::ocp) const OF_EACH_WORD: usize = 2;
    pub(in crate::ocp) const WORTH: f64 = 0.3;
}

/// Rules that make words of words.
pub(in crate::ocp) mod edits {
    /// Prices of the rules, relative to the objective: by how much the parent of a draft may be worse than that of another one and still
    /// come first. Chosen: cheap where solutions themselves ask for an edit.
    pub(in crate::ocp) mod price {
        /// Without all phases of no length.
        pub(in crate::ocp) const COLLAPSE: f64 = 0.0;
        /// Without one of them.
        pub(in crate::ocp) const VANISH: f64 = 0.0;
        /// A cycle where a solution presses.
        pub(in crate::ocp) const PRESS: f64 = 0.01;
        /// One contact otherwise.
        pub(in crate::ocp) const FLIP: f64 = 0.025;
        /// A touch.
        pub(in crate::ocp) const TOUCH: f64 = 0.03;
        /// Without the last instant.
        pub(in crate::ocp) const CUT: f64 = 0.04;
    }
    /// A phase shorter than this share of the motion has vanished. Follows: a little above [`super::off_grid::LEAST`].
    pub(in crate::ocp) const VANISHED: f64 = 3e-3;
    /// Length of what is inserted where a solution presses, a share of the motion, and of its phase the share that is left on both sides.
    /// Chosen: the program moves it from there.
    pub(in crate::ocp) const INSERTED: f64 = 0.08;
    pub(in crate::ocp) const ROOM: f64 = 0.02;
    /// By how much of a share a cycle that was seen once comes before one that was not. Chosen: it decides between equal ones.
    pub(in crate::ocp) const OFTEN: f64 = 1e-4;
    /// Most phases that are left out with one, up to one with the modes of the phase before it. Chosen.
    pub(in crate::ocp) const LEFT_OUT: usize = 4;
    /// Where in an open phase a touch is tried, shares of the phase. Chosen: in the middle, and before the landing that follows.
    pub(in crate::ocp) const TOUCHED: [f64; 2] = [0.5, 0.9];
}

/// Words that are put on the control grid.
pub(in crate::ocp) mod on_grid {
    /// Change of a control, as a share of its range, that is a jump, and share of the motion on either side of a switch in which it is looked
    /// for. Chosen.
    pub(in crate::ocp) const JUMP: f64 = 0.1;
    pub(in crate::ocp) const BESIDE_A_JUMP: f64 = 1e-3;
    /// Distance from an end of an interval, in intervals, at which a switch is there with or without a jump. Chosen.
    pub(in crate::ocp) const AT_AN_END: f64 = 0.05;
    /// Distance of a switch from an end of its interval, in intervals, within which it presses on it. Chosen.
    pub(in crate::ocp) const PRESSES: f64 = 0.03;
    /// First barrier parameter, and most iterations. Chosen: a program starts near its solution.
    pub(in crate::ocp) const BARRIER: f64 = 1e-3;
    pub(in crate::ocp) const ITERATIONS: usize = 100;
    /// By how much dearer a miss is where places miss their goals, how often, and the share of the miss that is no nearer. Measured:
    /// `stone-feet` of the families and `hop` of the zoo reach their goals so.
    pub(in crate::ocp) const DEARER: f64 = 30.0;
    pub(in crate::ocp) const DEARER_ROUNDS: usize = 2;
    pub(in crate::ocp) const NO_NEARER: f64 = 0.98;
    /// Relative excess over the word off the grid up to which its places are let be, most places that are tried beyond that, and how far from
    /// the end of its interval, in intervals, an instant starts there. Measured: half of the scenes come closer, and `train-buffers` from
    /// 353 to 197.
    pub(in crate::ocp) const NEAR: f64 = 0.02;
    pub(in crate::ocp) const SHIFTS: usize = 30;
    /// Most places of all switches at once that are tried after these. Chosen: all of two, but for those out of order.
    pub(in crate::ocp) const NEARBY: usize = 24;
    pub(in crate::ocp) const ENTRY: f64 = 0.1;
    /// Most moves of the switches of a word. Chosen.
    pub(in crate::ocp) const MOVES: usize = 8;
    /// Relative excess of the objective off the grid over the best on it beyond which a word is not put on it. Chosen: the grid mostly
    /// costs something.
    pub(in crate::ocp) const BEYOND: f64 = 1e-2;
    /// Words that are put on the grid, where one of them reaches the goals there. Chosen.
    pub(in crate::ocp) const PLACED: usize = 6;
    /// Words whose switches are moved, the best first, and the relative excess over the best up to which they are. Chosen.
    pub(in crate::ocp) const MOVED: usize = 3;
    pub(in crate::ocp) const MOVED_WITHIN: f64 = 2e-2;
    /// Most intervals of a grid that words are put on, and the fewest where a finer one is asked for. Chosen.
    pub(in crate::ocp) const FINE: usize = 40;
    pub(in crate::ocp) const LEAST: usize = 8;
    /// Motions on the grid that go on to the judge, the best first. Chosen.
    pub(in crate::ocp) const JUDGED: usize = 3;
    /// Simulated motions that programs start from where no word leads to one, and places where the motion of the guess may end that are looked
    /// at. Chosen: the one without controls, and the two best.
    pub(in crate::ocp) const SIMULATED: usize = 3;
    /// By how much elements become more at most where intervals are aligned with phases and a motion is not confirmed. Chosen.
    pub(in crate::ocp) const FINEST: usize = 8;
    /// Most words that are looked at on the way from an aligned one. Chosen.
    pub(in crate::ocp) const FOLLOWED: usize = 40;
}

/// Random motions of which the best of each order of events is kept.
pub(in crate::ocp) mod sampled {
    /// The same as of words ([`super::beginnings`]), for what is hard in a problem without a motion.
    pub(in crate::ocp) const DRAWN: u64 = 256;
    pub(in crate::ocp) const CHANGED: usize = 768;
    /// Motions under policies beside them, the latest time at which one turns round, as a share of the motion, and the natural sizes up to
    /// which a control without bounds goes. Measured: `kendama`, a kick and a grasp are found by them.
    pub(in crate::ocp) const POLICIES: u64 = 24;
    pub(in crate::ocp) const LATEST_TURN: f64 = 1.4;
    pub(in crate::ocp) const OF_SIZES: f64 = 4.0;
    /// How much longer than its random length, or than the one that it is made of, a motion with a free final time is followed. Chosen.
    pub(in crate::ocp) const LONGER: f64 = 2.0;
    pub(in crate::ocp) const LONGER_THAN_BEFORE: f64 = 1.5;
    /// Places where a motion may end, and where conditions are looked at: so many in an interval, and no fewer than these. Chosen.
    pub(in crate::ocp) const PLACES: usize = 8;
    pub(in crate::ocp) const LEAST_PLACES: usize = 64;
    /// Tolerance of simulations of which only the end counts, and violation of a goal or bound, in its unit, that simulation and
    /// interpolation may cause. Chosen: below [`super::equal::MET`].
    pub(in crate::ocp) const TOLERANCE: f64 = 1e-6;
    /// Most events of an order. Chosen.
    pub(in crate::ocp) const EVENTS: usize = 8;
    /// Share of the ends that miss a goal by less than its unit. Chosen: the worst do not decide.
    pub(in crate::ocp) const WITHIN: f64 = 0.75;
    /// Unit of the violation of bounds, as a share of what is between them. Chosen.
    pub(in crate::ocp) const OF_RANGE: f64 = 0.2;
    /// Distances, in units of the conditions, that differ by less are alike: then the cost decides. Chosen.
    pub(in crate::ocp) const ALIKE: f64 = 0.05;
    /// The best motions, one of which is changed in turn with any one. Chosen.
    pub(in crate::ocp) const BEST: usize = 8;
    /// By how much of their range values are changed at most, in turn. Chosen: each about a third of the one before.
    pub(in crate::ocp) const CHANGES: [f64; 4] = [0.5, 0.2, 0.07, 0.02];
    /// Ends of the random numbers, from -1 to 1, by which all controls are changed, those of one interval, or those of one that is moved.
    /// Follows: each as often.
    pub(in crate::ocp) const OF_EACH_KIND: f64 = 1.0 / 3.0;
    /// Motions by which ranges of random controls are compared, share of the bounds in the next narrower range, and most such
    /// steps. Chosen.
    pub(in crate::ocp) const PILOTS: u64 = 12;
    pub(in crate::ocp) const NARROWED: f64 = 0.25;
    pub(in crate::ocp) const NARROWER: i32 = 12;
}

/// Programs of contact sequences on a grid.
pub(in crate::ocp) mod attempt {
    /// Barrier parameter that a program is started with, and most iterations: of the first program of a sequence. Measured: of those that are
    /// solved from there, 49 of 50 take fewer; further tries from 1e-3 and 1e-1, and without a limit, find nothing more on 109 scenes
    /// (`docs/experiments/attempts.md`).
    pub(in crate::ocp) const FIRST: (f64, usize) = (1e-2, 130);
    /// The same of a neighbour, which starts near its solution, and at last, where something is claimed about it, from further away. Chosen.
    pub(in crate::ocp) const NEIGHBOUR: [(f64, usize); 2] = [(1e-4, 60), (1e-2, 300)];
    /// The same after a cut. Chosen.
    pub(in crate::ocp) const AFTER_CUT: (f64, usize) = (1e-5, 80);
    /// Tolerance of the first stage. Chosen: sequences that are worse are left there.
    pub(in crate::ocp) const FIRST_TOLERANCE: f64 = 2e-7;
    /// Most iterations of the second stage. Measured: none of 2500 that came to a solution took more.
    pub(in crate::ocp) const SECOND: usize = 100;
    /// Share of the largest pivots below which velocities are hardly determined by joints. Chosen: errors grow tenfold.
    pub(in crate::ocp) const DECIDED: f64 = 0.1;
    /// Rounds of cuts of one sequence. Chosen.
    pub(in crate::ocp) const ROUNDS: usize = 6;
    /// Share of the tolerance to which a result is polished, and most iterations. Measured: 248 of 259 took at most seven, none more than
    /// 18.
    pub(in crate::ocp) const POLISH: f64 = 1e-3;
    pub(in crate::ocp) const POLISH_ITERATIONS: usize = 30;
}

/// Neighbours of a contact sequence, and when a multiplier points to one. Lengths and distances are in intervals.
pub(in crate::ocp) mod neighbours {
    /// Switches of a contact closer than this may cancel each other. Chosen: those in one interval and the next.
    pub(in crate::ocp) const CLOSE: f64 = 1.1;
    /// A switch nearer to the end of its interval than this sticks there. Chosen.
    pub(in crate::ocp) const STUCK: f64 = 0.01;
    /// What lasts as long or longer is not held at the least lengths of phases. Follows: [`STUCK`] at both ends.
    pub(in crate::ocp) const APART: f64 = 2.0 * STUCK;
    /// A contact, or a slip, that is shorter may be no more than a touch, or a rest. Chosen: one interval or little more.
    pub(in crate::ocp) const SHORT: f64 = 1.5;
    /// Where a moved switch is started, as a distance from the end it came through. Chosen.
    pub(in crate::ocp) const ENTRY: f64 = 0.05;
    /// Half the length of an inserted contact or flight, and that of a second attempt. Chosen.
    pub(in crate::ocp) const INSERTED: [f64; 2] = [0.2, 0.03];
    /// Distance from a switch of the same contact within which no other one is inserted. Chosen: more than [`INSERTED`], twice.
    pub(in crate::ocp) const NEAR: f64 = 0.6;
    /// What the solver leaves: multipliers above this share of the largest one belong to conditions that matter, a normal acceleration
    /// above this share of that which holds a contact pulls it off, a force that keeps this share of the friction from both edges is within
    /// the cone, and what slides slower, in the unit of its row, does not move. Chosen: above the tolerance of the programs (1e-9).
    pub(in crate::ocp) const LEFT: f64 = 1e-6;
    /// A condition that is met with a distance to spare is active only where the multiplier, as a share of the largest one, is above this
    /// share of that distance. Chosen: the product of both is what the solver leaves of complementarity, so that a small multiplier at a
    /// distance means nothing.
    pub(in crate::ocp) const DISTANT: f64 = 1e-2;
    /// Multipliers of rows up to so many tolerances are errors, which add up over the phases: where all are, no condition keeps the motion
    /// from a better one. Chosen.
    pub(in crate::ocp) const NOTHING: f64 = 100.0;
    /// First barrier parameter, and most iterations, of programs whose new phases are held at their least lengths. Chosen: they start at
    /// their solution.
    pub(in crate::ocp) const HELD: (f64, usize) = (1e-5, 60);
    /// Share of that by which the objective of several at once may be lower than that of the best. Chosen: as precise as that is.
    pub(in crate::ocp) const PRECISION: f64 = 0.1;
    /// Least number of intervals between two with further phases in one program, which starts from the multipliers of the best where both
    /// have the same phases. Measured: with 1, 3, 7 `spinning-wheel` of the zoo on 80 intervals takes 333, 280, 392 programs.
    pub(in crate::ocp) const BETWEEN: usize = 3;
}

/// Motions that suggest contact sequences on a grid.
pub(in crate::ocp) mod candidates {
    /// Most switches of short contacts and flights for which a sequence is tried with them, too. Chosen: one contact or flight.
    pub(in crate::ocp) const SHORT_SWITCHES: usize = 2;
    /// Points of a simulation, and samples of a guess, in each interval. Chosen.
    pub(in crate::ocp) const OUTPUTS: usize = 10;
    pub(in crate::ocp) const SAMPLES: usize = 4;
    /// Parts of a motion without controls, which has one interval: what counts as short on equal intervals does so in these. Chosen.
    pub(in crate::ocp) const UNDRIVEN: usize = 20;
    /// A contact that closes within this share of the first interval was closed at the start. Chosen.
    pub(in crate::ocp) const AT_ONCE: f64 = 1e-3;
}

/// Guesses that programs start from.
pub(in crate::ocp) mod guesses {
    /// Exponent of the factor by which the horizon of a perturbed guess is changed at random. Chosen.
    pub(in crate::ocp) const PERTURBED_TIME: f64 = 0.15;
    /// By how much a guess is perturbed: controls, as a share of their range, or of their natural size where they have none, and
    /// coordinates with a goal, as a share of the distance to it. Chosen.
    pub(in crate::ocp) const OF_RANGE: f64 = 0.25;
    pub(in crate::ocp) const OF_SIZE: f64 = 0.1;
    pub(in crate::ocp) const OF_WAY: f64 = 0.05;
}

/// The time-freezing formulation.
pub(in crate::ocp) mod freezing {
    /// About so many intervals of the coarse grid on which one of the starts is. Chosen.
    pub(in crate::ocp) const NEAR: usize = 10;
    /// Starts beside the first: elements added, and a factor of the auxiliary acceleration. Chosen.
    pub(in crate::ocp) const VARIANTS: [(usize, f64); 4] = [(0, 1.0), (0, 0.5), (1, 1.0), (0, 2.0)];
    /// Mean step function of an element above which its contact is open. Follows: in flight it is 1, in contact `a_bar / (a_bar + r)` for
    /// a normal acceleration `r`.
    pub(in crate::ocp) const OPEN: f64 = 0.99;
    /// Time on the clock, in intervals, below which a contact that bounces has not come to rest: it stands during a jump. Chosen.
    pub(in crate::ocp) const BOUNCE: f64 = 0.05;
    /// Most iterations of one rule, and of the program that a search begins with. Chosen; measured: of 144 that one concludes within 1 % of
    /// the best in 33, in 23 within so many iterations and without restoring feasibility, in a fifth of the time.
    pub(in crate::ocp) const ITERATIONS: usize = 1500;
    pub(in crate::ocp) const FIRST: usize = 120;
    /// Most programs in which the plan that this leads to is proved. Chosen: beyond that the search does without it.
    pub(in crate::ocp) const PROVED: usize = 100;
    /// Shortest way to a goal, in the unit of its coordinate, beside which it begins so. Chosen: well above the tolerance of the program.
    pub(in crate::ocp) const SHORT: f64 = 1e-3;
    /// Tolerances of the exact program: its rows hold to the first one; where multipliers are not determined by it, its objective is
    /// stationary to the second one. Chosen.
    pub(in crate::ocp) const EXACT: [f64; 2] = [1e-9, 1e-6];
    /// Its first barrier parameter, the share of a barrier parameter by which this and other warm starts are kept off their bounds, and its
    /// most iterations. Chosen: they stay where they are.
    pub(in crate::ocp) const BARRIER: f64 = 1e-5;
    pub(in crate::ocp) const PUSH: f64 = 1e-2;
    pub(in crate::ocp) const EXACT_ITERATIONS: usize = 200;
    /// Steps of a phase as a guess of the program, and halvings of the range of the speed of its clock. Chosen; follows: to rounding.
    pub(in crate::ocp) const STEPS: usize = 16;
    pub(in crate::ocp) const HALVINGS: usize = 60;
}

/// Runs on one grid.
pub(in crate::ocp) mod grids {
    /// Motions that go on to a finer grid than the one that words are put on. Chosen.
    pub(in crate::ocp) const KEPT: usize = 2;
    /// Factor by which the elements of a phase become more where re-simulations contradict all plans. Chosen.
    pub(in crate::ocp) const FINER: usize = 2;
    /// Without controls: finite elements of a phase on one interval for each that is asked for. Chosen.
    pub(in crate::ocp) const ELEMENTS_OF_ONE: usize = 5;
    /// By how many stages the scheme grows where the re-simulation does not confirm a plan. Chosen.
    pub(in crate::ocp) const MORE_STAGES: usize = 2;
    /// How often the range of final times is moved, each time by a factor of 20 at most, or the units. Chosen.
    pub(in crate::ocp) const MOVES: usize = 5;
    /// Factor from the centre of a moved range within which a plan is measured in units of its own size. Chosen: one that is further away may
    /// be no more than flat in those of its program.
    pub(in crate::ocp) const OFF_CENTRE: f64 = 1.5;
    /// Distance of a plan from its re-simulation beyond which it is no motion \[m or rad, in scenes of the order of these\]. Chosen.
    pub(in crate::ocp) const NO_MOTION: f64 = 1e-2;
}

/// What shows that no motion exists.
pub(in crate::ocp) mod impossible {
    /// Steps towards the nearest point. Measured: two weights are found in a few.
    pub(in crate::ocp) const STEPS: usize = 500;
    /// Longest final time that is looked at, to the given one, and how exactly the least one that is not impossible is found. Chosen.
    pub(in crate::ocp) const LONGEST: f64 = 1e6;
    pub(in crate::ocp) const PRECISION: f64 = 1e-3;
}

/// Free final times where rest costs nothing.
pub(in crate::ocp) mod waiting {
    /// Prices of the length of a motion, in sizes of the objective, with which it is looked for and solved, and then solved once more. Chosen: well above the tolerance of the programs, and below what differences of objectives count.
    pub(in crate::ocp) const FIRST: f64 = 1e-4;
    pub(in crate::ocp) const SECOND: f64 = 1e-6;
    /// How many times as long a motion is that would cost less, and by how much less, relative, if there is no best length. Chosen: what falls as the
    /// power `-k` of the time falls by `1 - 2^-k`, which is more for all `k` above 0.03.
    pub(in crate::ocp) const LONGER: f64 = 2.0;
    pub(in crate::ocp) const LESS: f64 = 0.02;
}
