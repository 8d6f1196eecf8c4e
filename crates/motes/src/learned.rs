//! A learned proposal as the command has it: in a folder, with a name, for one model.

use std::borrow::Cow;
use std::fmt;
use std::path::Path;
use std::sync::Arc;

use motes_formulas::Prior;
use motes_models::{ModelShape, Seed};
use motes_proposals::{
    Amortised, Backend, Fingerprint, LearnedPotentials, OnLinePotentials, PotentialStandards, SavedError,
    SavedFiles, holds, load, load_to_tune, notes, save, save_both,
};
use motes_smc::{ByPotential, LookAhead, RecordedStep};
use serde::{Deserialize, Serialize};

use crate::error::MotesError;
use crate::evidence::LearnedWorth;
use crate::filter_source::FilterSource;
use crate::learned_notes::{Notes, PotentialNotes};
use crate::model::{Kind, Model};
use crate::own_model::LearnableModel;
use crate::packed::{pack, unpack};
use crate::priors::free;
use crate::training_prior::TrainingPrior;

/// A proposal that was learned for a model; copies share it.
#[derive(Clone)]
pub struct LearnedProposal {
    name: String,
    /// A network for each particle; none where potentials were learned alone, over a prior.
    proposal: Option<Arc<Amortised>>,
    potentials: Option<Arc<PotentialsWithNotes>>,
    notes: Arc<Notes>,
    /// The units of a model that was found to be the right one, where they are found for each.
    standards: Option<Arc<PotentialStandards>>,
    /// Of the model that it was learned or loaded for; over a prior, at the parameters that the prior's notes name.
    fingerprint: Arc<Fingerprint>,
}

/// Potentials of whole recorded sequences and of steps.
#[derive(Clone)]
struct PotentialsWithNotes {
    potentials: Arc<LearnedPotentials>,
    notes: PotentialNotes,
}

/// What errors call a proposal that is bytes.
const IN_BYTES: &str = "a learned proposal";

/// The version of what the bytes hold, beside that of the files in them.
const BYTES_VERSION: u32 = 4;

/// What the bytes of a proposal hold.
#[derive(Serialize, Deserialize)]
struct NamedFiles {
    name: String,
    files: Option<SavedFiles>,
    potentials: Option<SavedFiles>,
}

impl fmt::Debug for LearnedProposal {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.debug_struct("LearnedProposal").field("name", &self.name).finish_non_exhaustive()
    }
}

/// What networks are made from: sizes, and the graph of what depends on what, which is the same whenever it is asked for.
pub(crate) fn shape_of(model: &dyn LearnableModel) -> ModelShape {
    ModelShape::on_dependences(model, &Seed::from_u64(0).child("dependences"))
}

impl PartialEq for LearnedProposal {
    /// Whether they are the same one.
    fn eq(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.fingerprint, &other.fingerprint)
    }
}

impl LearnedProposal {
    pub(crate) fn new(
        name: String,
        proposal: Option<Amortised>,
        notes: Notes,
        model: &dyn LearnableModel,
    ) -> Self {
        let fingerprint = Arc::new(Fingerprint::of(model, None));
        LearnedProposal {
            name,
            proposal: proposal.map(Arc::new),
            potentials: None,
            notes: Arc::new(notes),
            standards: None,
            fingerprint,
        }
    }

    /// The same for series of a model whose units are found once for all of them.
    ///
    /// # Errors
    /// [`MotesError::Proposal`] if `model` is another one than it was learned for.
    pub(crate) fn prepared(self, model: &Model) -> Result<Self, MotesError> {
        self.check_model(model)?;
        let Some(learned) = &self.potentials else { return Ok(self) };
        let found = learned.potentials.standards(learnable(model)?);
        let standards = found.map_err(|error| self.refused(&error))?;
        Ok(LearnedProposal { standards: Some(Arc::new(standards)), ..self })
    }

    /// The same with potentials beside it.
    pub(crate) fn with_potentials(self, potentials: LearnedPotentials, notes: PotentialNotes) -> Self {
        LearnedProposal {
            potentials: Some(Arc::new(PotentialsWithNotes { potentials: Arc::new(potentials), notes })),
            ..self
        }
    }

    /// The same without potentials.
    pub(crate) fn without_potentials(self) -> Self {
        LearnedProposal { potentials: None, ..self }
    }

    /// The same, whose filters draw by something else.
    pub(crate) fn filtering_by(self, filters: FilterSource) -> Self {
        match self.potential_notes().cloned() {
            Some(notes) => self.with_potential_notes(PotentialNotes { filters, ..notes }),
            None => self,
        }
    }

    /// Whether recorded data are better looked at by the potentials of a smoother.
    pub(crate) fn hands_out_look_ahead(&self) -> bool {
        let worth = self.potential_notes().and_then(|notes| notes.worth.as_ref());
        worth.is_some_and(LearnedWorth::is_behind_look_ahead)
    }

    /// What filters draw by that take in one measurement after another.
    pub fn filters(&self) -> &FilterSource {
        self.potentials.as_ref().map_or(&FilterSource::Network, |learned| &learned.notes.filters)
    }

    /// The name of the designed proposal that filters take in its place, where nothing that was learned pays for them.
    pub fn designed_filter(&self) -> Option<&str> {
        match self.filters() {
            FilterSource::Designed(name) => Some(name),
            FilterSource::Network | FilterSource::Potential => None,
        }
    }

    /// The potentials by which a filter of `model` draws as measurements come, if it does.
    ///
    /// # Errors
    /// [`MotesError::Proposal`] if their units cannot be had.
    pub(crate) fn on_line(
        &self,
        model: &dyn LearnableModel,
    ) -> Result<Option<ByPotential<OnLinePotentials>>, MotesError> {
        let is_asked = *self.filters() == FilterSource::Potential;
        let potentials = self.potentials.as_ref().filter(|_| is_asked);
        let proposal = potentials
            .map(|learned| OnLinePotentials::proposal(Arc::clone(&learned.potentials), model))
            .transpose();
        proposal.map_err(|error| self.refused(&error))
    }

    /// Whether there are potentials for recorded data.
    pub fn has_potentials(&self) -> bool {
        self.potentials.is_some()
    }

    /// What was written down of its potentials when they were learned.
    pub fn potential_notes(&self) -> Option<&PotentialNotes> {
        self.potentials.as_ref().map(|learned| &learned.notes)
    }

    /// The same with other notes of its potentials.
    pub(crate) fn with_potential_notes(self, notes: PotentialNotes) -> Self {
        let with_notes = |learned: &PotentialsWithNotes| {
            Arc::new(PotentialsWithNotes { potentials: learned.potentials.clone(), notes })
        };
        LearnedProposal { potentials: self.potentials.as_deref().map(with_notes), ..self }
    }

    /// The potentials of a recorded series, where they were learned.
    ///
    /// # Errors
    /// [`MotesError::Proposal`] if `model` is another one than it was learned for, or the networks fail.
    pub(crate) fn look_ahead(
        &self,
        model: &Model,
        steps: &[RecordedStep],
    ) -> Result<Option<LookAhead>, MotesError> {
        let Some(learned) = &self.potentials else { return Ok(None) };
        let Some(standards) = &self.standards else {
            return self.clone().prepared(model)?.look_ahead(model, steps);
        };
        let found = learned.potentials.look_ahead_in(standards, learnable(model)?, steps);
        found.map(Some).map_err(|error| self.refused(&error))
    }

    /// The same with other notes.
    pub(crate) fn with_notes(self, notes: Notes) -> Self {
        LearnedProposal { notes: Arc::new(notes), ..self }
    }

    /// Whether `model` is the one that it was learned for, or loaded for, with the same parameters: by its densities, as where a folder is read. Over a prior, those that have one may be
    /// any.
    ///
    /// Filters, comparisons and further learning ask this themselves.
    ///
    /// # Errors
    /// [`MotesError::Proposal`] with what differs, if it is another one; as [`learn`](crate::learn) for a model that nothing is learned for.
    pub fn check_model(&self, model: &Model) -> Result<(), MotesError> {
        let reference = self.reference(model)?;
        let found = self.fingerprint.check(&Fingerprint::of(learnable(&reference)?, None));
        found.map_err(|error| self.refused(&error))
    }

    /// The prior that its potentials were learned over, if they were.
    pub(crate) fn prior(&self) -> Option<&TrainingPrior> {
        self.potential_notes()?.prior.as_ref()
    }

    /// Whether it serves all values of the parameters that have a prior and no other value.
    ///
    /// # Errors
    /// [`MotesError::Proposal`] with the first that it was learned for one value of.
    pub(crate) fn check_free(&self, model: &Model) -> Result<(), MotesError> {
        let over = self.potential_notes().and_then(|notes| notes.prior.as_ref()).map(TrainingPrior::names);
        let over = over.unwrap_or_default();
        match free(model).map(Prior::name).find(|name| !over.contains(name)) {
            None => Ok(()),
            Some(name) => Err(self.refused(&format!(
                "it was learned for one value of {name}, which is to be fitted; motes learn MODEL -o FOLDER, without data, --set {name} and options of a network, learns over the prior"
            ))),
        }
    }

    /// The model at the parameters by which it is recognised.
    fn reference<'m>(&self, model: &'m Model) -> Result<Cow<'m, Model>, MotesError> {
        reference(self.potential_notes().and_then(|notes| notes.prior.as_ref()), model, &self.name)
    }

    /// The error of a model for which it does not work.
    pub(crate) fn refused(&self, error: &dyn fmt::Display) -> MotesError {
        MotesError::Proposal { proposal: self.name.clone(), reason: error.to_string() }
    }

    /// Reads the proposal in `folder`, which was learned for `model`.
    ///
    /// # Errors
    /// [`MotesError::Saved`] if it is not there, damaged, or learned for another model.
    pub fn load(folder: &Path, model: &Model) -> Result<Self, MotesError> {
        let (of_proposal, of_potentials) = (holds::<Amortised>(folder), holds::<LearnedPotentials>(folder));
        let notes_beside: Option<PotentialNotes> =
            of_potentials.then(|| notes::<LearnedPotentials, _>(folder)).transpose()?;
        let prior = notes_beside.as_ref().and_then(|notes| notes.prior.as_ref());
        let reference = reference(prior, model, &name_of(folder))?;
        let learnable = learnable(&reference)?;
        let (shape, compute) = (shape_of(learnable), Backend::Native.into());
        let own = notes_beside.as_ref().and_then(|notes| notes.folder_notes.clone());
        let learned = match own {
            Some(own) if !of_proposal => LearnedProposal::new(name_of(folder), None, own, learnable),
            _ => LearnedProposal::named(folder, load(folder, learnable, &shape, compute)?, learnable)?,
        };
        let Some(notes) = notes_beside else { return Ok(learned) };
        Ok(learned.with_potentials(load(folder, learnable, &shape, compute)?, notes))
    }

    /// Reads the proposal in `folder` to be learned further for `model`, whose parameters may be others than those it was learned for.
    ///
    /// # Errors
    /// [`MotesError::Saved`] if it is not there, damaged, or learned for a model with other numbers of states or measurements; [`MotesError::Proposal`] if it holds potentials alone.
    pub fn load_to_tune(folder: &Path, model: &Model) -> Result<Self, MotesError> {
        let learnable = learnable(model)?;
        if holds::<LearnedPotentials>(folder) && !holds::<Amortised>(folder) {
            let reason = "it holds potentials alone, learned over a prior, which are not learned further";
            return Err(MotesError::Proposal { proposal: name_of(folder), reason: reason.into() });
        }
        let proposal = load_to_tune(folder, &shape_of(learnable), Backend::Native.into())?;
        LearnedProposal::named(folder, proposal, learnable)
    }

    /// What a folder is called, with what it says beside the weights.
    fn named(folder: &Path, proposal: Amortised, model: &dyn LearnableModel) -> Result<Self, MotesError> {
        let notes = notes::<Amortised, _>(folder)?;
        Ok(LearnedProposal::new(name_of(folder), Some(proposal), notes, model))
    }

    /// Writes it into `folder`, replacing a proposal that is there.
    ///
    /// # Errors
    /// [`MotesError::Saved`] if it cannot be written; [`MotesError::Proposal`] if `model` is another one than it was learned for.
    pub fn save(&self, folder: &Path, model: &Model) -> Result<(), MotesError> {
        self.check_model(model)?;
        let reference = self.reference(model)?;
        let learnable = learnable(&reference)?;
        let (shape, own) = (shape_of(learnable), &*self.notes);
        match (self.proposal.as_deref(), self.potentials.as_deref()) {
            (Some(proposal), None) => save(folder, proposal, learnable, &shape, own)?,
            (Some(proposal), Some(PotentialsWithNotes { potentials, notes })) => {
                save_both(folder, (proposal, own), (&**potentials, notes), learnable, &shape)?;
            }
            (None, Some(PotentialsWithNotes { potentials, notes })) => {
                let notes = PotentialNotes { folder_notes: Some(own.clone()), ..notes.clone() };
                save(folder, &**potentials, learnable, &shape, &notes)?;
            }
            (None, None) => {}
        }
        Ok(())
    }

    /// It as bytes, for who keeps it elsewhere than in a folder; `model` is the one that it was learned for.
    ///
    /// # Errors
    /// As [`LearnedProposal::save`].
    pub fn to_bytes(&self, model: &Model) -> Result<Vec<u8>, MotesError> {
        self.check_model(model)?;
        let reference = self.reference(model)?;
        let learnable = learnable(&reference)?;
        let shape = shape_of(learnable);
        let place = Path::new(IN_BYTES);
        let of_proposal =
            |proposal: &Amortised| SavedFiles::of(proposal, learnable, &shape, &*self.notes, place);
        let files = self.proposal.as_deref().map(of_proposal).transpose()?;
        let of_potentials = |PotentialsWithNotes { potentials, notes }: &PotentialsWithNotes| {
            let own = files.is_none().then(|| Notes::clone(&self.notes));
            let notes = PotentialNotes { folder_notes: own, ..notes.clone() };
            SavedFiles::of(&**potentials, learnable, &shape, &notes, place)
        };
        let potentials = self.potentials.as_deref().map(of_potentials).transpose()?;
        pack(IN_BYTES, BYTES_VERSION, &NamedFiles { name: self.name.clone(), files, potentials })
    }

    /// The proposal of which [`LearnedProposal::to_bytes`] made `bytes`, to the last bit.
    ///
    /// # Errors
    /// [`MotesError::Packed`] if they were damaged or are of another version; [`MotesError::Saved`] if it was learned for another model.
    pub fn from_bytes(bytes: &[u8], model: &Model) -> Result<Self, MotesError> {
        let NamedFiles { name, files, potentials } = unpack(IN_BYTES, BYTES_VERSION, bytes)?;
        let place = Path::new(IN_BYTES);
        let notes_beside: Option<PotentialNotes> =
            potentials.as_ref().map(|files| files.notes(place)).transpose()?;
        let prior = notes_beside.as_ref().and_then(|notes| notes.prior.as_ref());
        let reference = reference(prior, model, &name)?;
        let learnable = learnable(&reference)?;
        let (shape, compute) = (shape_of(learnable), Backend::Native.into());
        let learned = match (files, notes_beside.as_ref().and_then(|notes| notes.folder_notes.clone())) {
            (Some(files), _) => {
                let proposal = files.proposal(place, learnable, &shape, compute)?;
                LearnedProposal::new(name, Some(proposal), files.notes(place)?, learnable)
            }
            (None, Some(own)) => LearnedProposal::new(name, None, own, learnable),
            (None, None) => {
                let reason = "there is nothing learned in it".to_string();
                return Err(MotesError::Proposal { proposal: name, reason });
            }
        };
        let Some((files, notes)) = potentials.zip(notes_beside) else { return Ok(learned) };
        Ok(learned.with_potentials(files.proposal(place, learnable, &shape, compute)?, notes))
    }

    /// What it is called on a card.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// What was written down when it was learned.
    pub fn notes(&self) -> &Notes {
        &self.notes
    }

    /// The network for each particle, for [`motes_smc::ParticleFilter`]; none where potentials were learned alone.
    pub fn proposal(&self) -> Option<&Amortised> {
        self.proposal.as_deref()
    }
}

/// The model at the parameters by which a proposal of that name recognises it.
fn reference<'m>(
    prior: Option<&TrainingPrior>,
    model: &'m Model,
    name: &str,
) -> Result<Cow<'m, Model>, MotesError> {
    prior.map_or(Ok(Cow::Borrowed(model)), |prior| prior.reference(model, name).map(Cow::Owned))
}

/// What a proposal in a folder is called.
fn name_of(folder: &Path) -> String {
    folder.file_name().unwrap_or(folder.as_os_str()).to_string_lossy().into_owned()
}

/// What a proposal is learned for; a linear Gaussian model by its matrices is none.
pub(crate) fn learnable(model: &Model) -> Result<&dyn LearnableModel, MotesError> {
    match model.kind() {
        Kind::Learnable(learnable) => Ok(learnable),
        Kind::LinearGaussian(_) => Err(MotesError::Proposal {
            proposal: "learned".into(),
            reason: "nothing is left to learn for kind = \"linear-gaussian\": take --proposal optimal, which is exact".into(),
        }),
    }
}

impl From<SavedError> for MotesError {
    fn from(error: SavedError) -> Self {
        MotesError::Saved(error)
    }
}
