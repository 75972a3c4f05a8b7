//! Scenes that the language does not declare: surfaces that repeat or depend on each other, moving belts.

use hangtime::model::{ContactDeclaration, Declaration, Model, tangent_point};

/// The dynamics of one scene with contacts from several that differ in their surfaces only.
pub(crate) struct Assembled {
    /// The first one gives the dynamics.
    scenes: Vec<Box<dyn Model>>,
    /// Scene and contact behind each contact.
    contacts: Vec<(usize, usize)>,
    /// Speed of the ground under every contact.
    belt: f64,
    declaration: &'static Declaration,
}

impl Assembled {
    /// What is declared lives as long as the test program.
    fn new(scenes: Vec<Box<dyn Model>>, contacts: Vec<(usize, usize)>, belt: f64) -> Self {
        let declared: Vec<ContactDeclaration> = contacts
            .iter()
            .map(|&(scene, contact)| scenes[scene].declaration().contacts[contact])
            .collect();
        let declaration = Declaration {
            contacts: declared.leak(),
            ..*scenes[0].declaration()
        };
        Self {
            scenes,
            contacts,
            belt,
            declaration: Box::leak(Box::new(declaration)),
        }
    }

    /// A scene with its contacts in any order and number.
    pub(crate) fn repeating(scene: &dyn Model, contacts: &[usize]) -> Self {
        let contacts = contacts.iter().map(|&contact| (0, contact)).collect();
        Self::new(vec![scene.boxed()], contacts, 0.0)
    }

    /// All contacts of scenes with the same dynamics, the first contact of each first.
    pub(crate) fn joining(scenes: Vec<Box<dyn Model>>) -> Self {
        let each = scenes[0].declaration().contacts.len();
        let contacts = (0..each)
            .flat_map(|contact| (0..scenes.len()).map(move |scene| (scene, contact)))
            .collect();
        Self::new(scenes, contacts, 0.0)
    }

    /// A scene on ground that moves with the speed `belt`.
    pub(crate) fn on_belt(scene: &dyn Model, belt: f64) -> Self {
        let contacts = (0..scene.declaration().contacts.len())
            .map(|contact| (0, contact))
            .collect();
        Self::new(vec![scene.boxed()], contacts, belt)
    }

    fn behind(&self, contact: usize) -> (&dyn Model, usize) {
        let (scene, contact) = self.contacts[contact];
        (&*self.scenes[scene], contact)
    }
}

impl Model for Assembled {
    fn declaration(&self) -> &'static Declaration {
        self.declaration
    }

    fn parameter(&self, index: usize) -> f64 {
        self.scenes[0].parameter(index)
    }

    fn set_parameter(&mut self, index: usize, value: f64) {
        self.scenes[0].set_parameter(index, value);
    }

    fn start(&self, q: &mut [f64], v: &mut [f64]) {
        self.scenes[0].start(q, v);
    }

    fn horizon(&self) -> Option<f64> {
        self.scenes[0].horizon()
    }

    fn bounds(&self, lower: &mut [f64], upper: &mut [f64]) {
        self.scenes[0].bounds(lower, upper);
    }

    fn free_acceleration(&self, x: &[f64], a: &mut [f64]) {
        self.scenes[0].free_acceleration(x, a);
    }

    fn free_jacobian(&self, x: &[f64], values: &mut [f64]) {
        self.scenes[0].free_jacobian(x, values);
    }

    fn free_hessian(&self, x: &[f64], multipliers: &[f64], values: &mut [f64]) {
        self.scenes[0].free_hessian(x, multipliers, values);
    }

    fn mass_matrix(&self, x: &[f64], m: &mut [f64]) {
        self.scenes[0].mass_matrix(x, m);
    }

    fn energy(&self, x: &[f64], energy: &mut [f64]) {
        self.scenes[0].energy(x, energy);
    }

    fn gap(&self, contact: usize, x: &[f64]) -> f64 {
        let (scene, contact) = self.behind(contact);
        scene.gap(contact, x)
    }

    fn contact(&self, contact: usize, x: &[f64], point: &mut [f64]) {
        let (scene, contact) = self.behind(contact);
        scene.contact(contact, x, point);
    }

    fn contact_jacobian(&self, contact: usize, x: &[f64], values: &mut [f64]) {
        let (scene, contact) = self.behind(contact);
        scene.contact_jacobian(contact, x, values);
    }

    fn contact_hessian(&self, contact: usize, x: &[f64], multipliers: &[f64], values: &mut [f64]) {
        let (scene, contact) = self.behind(contact);
        scene.contact_hessian(contact, x, multipliers, values);
    }

    fn restitution(&self, contact: usize) -> f64 {
        let (scene, contact) = self.behind(contact);
        scene.restitution(contact)
    }

    fn friction(&self, contact: usize) -> f64 {
        let (scene, contact) = self.behind(contact);
        scene.friction(contact)
    }

    fn tangent(&self, contact: usize, x: &[f64], point: &mut [f64]) {
        let (scene, contact) = self.behind(contact);
        scene.tangent(contact, x, point);
        point[tangent_point::SLIDING_VELOCITY] -= self.belt;
    }

    fn tangent_jacobian(&self, contact: usize, x: &[f64], values: &mut [f64]) {
        let (scene, contact) = self.behind(contact);
        scene.tangent_jacobian(contact, x, values);
    }

    fn tangent_hessian(&self, contact: usize, x: &[f64], multipliers: &[f64], values: &mut [f64]) {
        let (scene, contact) = self.behind(contact);
        scene.tangent_hessian(contact, x, multipliers, values);
    }

    fn boxed(&self) -> Box<dyn Model> {
        Box::new(Self {
            scenes: self.scenes.iter().map(|scene| scene.boxed()).collect(),
            contacts: self.contacts.clone(),
            ..*self
        })
    }
}
