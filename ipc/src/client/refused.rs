//! What iceoryx2 says when it does not send, in a client's words.

use super::ClientError;
use iceoryx2::port::client::RequestSendError;
use iceoryx2::port::{LoanError, SendError};

pub(super) fn from_send(error: RequestSendError) -> ClientError {
    match error {
        RequestSendError::ExceedsMaxActiveRequests => ClientError::TooManyRequests,
        RequestSendError::SendError(SendError::UnableToDeliver) => ClientError::Overloaded,
        RequestSendError::SendError(SendError::LoanError(error)) => from_loan(error, 0),
        RequestSendError::SendError(error) => ClientError::transport("request port", error),
    }
}

pub(super) fn from_loan(error: LoanError, bytes: usize) -> ClientError {
    match error {
        LoanError::ExceedsMaxLoans => ClientError::TooManyRequests,
        LoanError::OutOfMemory | LoanError::ExceedsMaxLoanSize => ClientError::NoMemory(bytes),
        LoanError::InternalFailure => ClientError::transport("request memory", error),
    }
}
