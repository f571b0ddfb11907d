//! Round trips: a request that leaves the model, its work outside, and the reply that comes back to the model.
//!
//! A new one is a type with [`Request`], or with [`Computation`] where it needs nothing but itself, in the file of what
//! asks for it.

use std::any::{Any, type_name};
use std::fmt::{self, Debug, Formatter};
use std::marker::PhantomData;

use tokio::sync::mpsc::UnboundedSender;

use crate::message::{Effect, Msg};
use crate::model::Model;
use crate::services::Services;

/// What the model asks of the world outside.
pub trait Request: Any + Debug + Send + Sized {
    /// What comes back, any number of times.
    type Reply: Debug + Send + 'static;

    /// Begins the work; what takes time runs in the background.
    fn perform(self, services: &mut Services, replies: Replies<Self>);

    /// Applies a reply to the model; one that is no longer awaited is dropped. Nothing comes of a request without
    /// a reply.
    fn reply(_model: &mut Model, _reply: Self::Reply) -> Vec<Effect> {
        Vec::new()
    }

    /// Notes in the model that it goes out.
    fn sent(&self, _model: &mut Model) {}

    /// The reply, where the work needs nothing but the request.
    ///
    /// # Errors
    /// The work needs more: the request as it was.
    fn at_once(self) -> Result<Self::Reply, Self> {
        Err(self)
    }
}

/// A request whose work needs nothing but itself: milliseconds, or seconds for every measure of a long recording. It
/// runs on a thread of its own; where nothing waits for keys (screenshots, tests) at once.
pub trait Computation: Any + Debug + Send + Sized {
    /// What is computed.
    type Value: Debug + Send + 'static;

    /// Computes it.
    fn compute(self) -> Self::Value;

    /// Takes the value, unless something newer was requested.
    fn take(model: &mut Model, value: Self::Value);
}

impl<C: Computation> Request for C {
    type Reply = C::Value;

    fn perform(self, services: &mut Services, replies: Replies<Self>) {
        services.background(replies, move || self.compute());
    }

    fn reply(model: &mut Model, reply: Self::Reply) -> Vec<Effect> {
        C::take(model, reply);
        Vec::new()
    }

    fn at_once(self) -> Result<Self::Reply, Self> {
        Ok(self.compute())
    }
}

/// Where the replies to a request go.
pub struct Replies<R> {
    sender: UnboundedSender<Msg>,
    request: PhantomData<fn(R)>,
}

impl<R: Request> Replies<R> {
    /// Replies that go to this receiver of messages.
    pub fn new(sender: UnboundedSender<Msg>) -> Self {
        Self {
            sender,
            request: PhantomData,
        }
    }

    /// Sends a reply; says whether the loop still takes it.
    pub fn send(&self, reply: R::Reply) -> bool {
        self.sender.send(Msg::reply::<R>(reply)).is_ok()
    }

    /// Says what went wrong.
    pub fn complain(&self, why: String) {
        // The receiver is gone once the loop has ended.
        let _ = self.sender.send(Msg::Complaint(why));
    }
}

impl<R: Request> Clone for Replies<R> {
    fn clone(&self) -> Self {
        Self::new(self.sender.clone())
    }
}

/// A request of any type, as an effect carries it.
pub trait AnyRequest: Any + Debug + Send {
    /// Begins the work.
    fn perform(self: Box<Self>, services: &mut Services);

    /// Notes in the model that it goes out.
    fn sent(&self, model: &mut Model);

    /// The message with the reply, where the work needs nothing but the request.
    ///
    /// # Errors
    /// The work needs more: the request as it was.
    fn at_once(self: Box<Self>) -> Result<Msg, Box<dyn AnyRequest>>;
}

impl<R: Request> AnyRequest for R {
    fn perform(self: Box<Self>, services: &mut Services) {
        let replies = Replies::new(services.sender.clone());
        Request::perform(*self, services, replies);
    }

    fn sent(&self, model: &mut Model) {
        Request::sent(self, model);
    }

    fn at_once(self: Box<Self>) -> Result<Msg, Box<dyn AnyRequest>> {
        match Request::at_once(*self) {
            Ok(reply) => Ok(Msg::reply::<R>(reply)),
            Err(request) => Err(Box::new(request)),
        }
    }
}

/// A reply of any type, as a message carries it.
pub trait AnyReply: Any + Debug + Send {
    /// Applies it to the model.
    fn apply(self: Box<Self>, model: &mut Model) -> Vec<Effect>;
}

struct ReplyTo<R: Request>(R::Reply);

impl<R: Request> AnyReply for ReplyTo<R> {
    fn apply(self: Box<Self>, model: &mut Model) -> Vec<Effect> {
        R::reply(model, self.0)
    }
}

impl<R: Request> Debug for ReplyTo<R> {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        write!(f, "{}: {:?}", type_name::<R>(), self.0)
    }
}

impl Msg {
    /// A reply to a request.
    #[must_use]
    pub fn reply<R: Request>(reply: R::Reply) -> Self {
        Self::Reply(Box::new(ReplyTo::<R>(reply)))
    }

    /// The reply, if it is one to this request.
    #[cfg(test)]
    pub fn into_reply<R: Request>(self) -> Option<R::Reply> {
        let Self::Reply(reply) = self else {
            return None;
        };
        let reply: Box<dyn Any> = reply;
        Some(reply.downcast::<ReplyTo<R>>().ok()?.0)
    }
}

impl<R: Request> From<R> for Effect {
    fn from(request: R) -> Self {
        Self::Request(Box::new(request))
    }
}

impl Effect {
    /// The message with the reply, where the work needs nothing but the request.
    ///
    /// # Errors
    /// It is another effect, which is given back.
    pub fn at_once(self) -> Result<Msg, Self> {
        match self {
            Self::Request(request) => request.at_once().map_err(Self::Request),
            other => Err(other),
        }
    }

    /// The request, if it is one of this type.
    #[must_use]
    pub fn request<R: Request>(&self) -> Option<&R> {
        let Self::Request(request) = self else {
            return None;
        };
        let request: &dyn Any = request.as_ref();
        request.downcast_ref()
    }

    /// The request, if it is one of this type.
    ///
    /// # Errors
    /// It is another effect, which is given back.
    pub fn into_request<R: Request>(self) -> Result<R, Self> {
        if self.request::<R>().is_none() {
            return Err(self);
        }
        let Self::Request(request) = self else {
            return Err(self);
        };
        let request: Box<dyn Any> = request;
        Ok(*request
            .downcast()
            .unwrap_or_else(|_| unreachable!("its type was asked for")))
    }
}
