//! The way to who answers through a [`Carrier`].

use super::carrier::{Asked, Carrier, Outcome, answers};
use super::link::{Link, Stream};
use super::prepared::Prepared;
use super::{Best, Columns, PlannerError};
use crate::client_error::ClientError;
use crate::control::{ControlReply, ControlRequest};
use crate::limits::WIRE_VERSION;
use crate::wire::{RequestHeader, WireError};
use std::sync::Arc;
use std::time::Duration;

/// The way to who answers through a carrier.
#[derive(Debug)]
pub(super) struct Here<C>(pub(super) C);

impl<C: Carrier> Link for Here<C> {
    fn control(
        &self,
        message: &ControlRequest,
        _stop: &dyn Fn() -> bool,
    ) -> Result<ControlReply, ClientError> {
        self.control_once(message)
    }

    fn control_once(&self, message: &ControlRequest) -> Result<ControlReply, ClientError> {
        Ok(self.0.control(message.clone()))
    }

    fn boot_id(&self) -> Option<u64> {
        // This process is started once.
        Some(0)
    }

    fn send(&self, prepared: &Prepared, path: &[f64]) -> Result<Box<dyn Stream>, PlannerError> {
        let asked = written(prepared, path)?;
        let request_id = asked.header.request_id;
        let (inbox, outcome) = answers(request_id);
        self.0.send(asked, inbox)?;
        Ok(Box::new(Answering {
            outcome,
            request_id,
        }))
    }
}

/// As it travels.
fn written(prepared: &Prepared, path: &[f64]) -> Result<Asked, WireError> {
    let mut header = RequestHeader {
        wire_version: WIRE_VERSION,
        header_len: size_of::<RequestHeader>() as u32,
        // A gateway takes requests of one number for one: the clock has the same time in two threads.
        request_id: crate::time::next_number(),
        ..prepared.header
    };
    let body = prepared.sections.body();
    let numbers = crate::wire::request::path_numbers(header.waypoints, header.variables)?;
    let bytes = body.lay_out(&mut header, numbers);
    let mut words = vec![0_u64; bytes.div_ceil(8)];
    let payload: &mut [u8] = bytemuck::cast_slice_mut(&mut words);
    body.write(&header, payload);
    let rows = bytemuck::cast_slice_mut(&mut payload[..numbers * 8]);
    prepared.columns.write(path, rows);
    Ok(Asked { header, words })
}

/// The stream of answers. Dropping it cancels the request.
#[derive(Debug)]
struct Answering {
    outcome: Outcome,
    request_id: u64,
}

impl Stream for Answering {
    fn request_id(&self) -> u64 {
        self.request_id
    }

    fn next(
        &mut self,
        timeout: Duration,
        columns: &Arc<Columns>,
    ) -> Result<Option<Best>, ClientError> {
        let answered = self.outcome.next(timeout)?;
        Ok(answered.map(|answered| Best::own(answered, columns.clone())))
    }

    fn finish_early(&self) {
        self.outcome.finish_early();
    }

    fn sent(&self, _columns: &Columns) -> Option<Vec<f64>> {
        None
    }
}
