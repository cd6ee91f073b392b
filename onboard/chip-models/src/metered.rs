//! Ports that report when the model behind them works. A measurement of a driver can then exclude the model's
//! work.

use embedded_hal::spi::{ErrorType as SpiErrorType, Operation, SpiDevice};
use embedded_io::{ErrorType, Read, ReadReady, Write, WriteReady};

/// An observer that is notified when a model works.
pub trait WorkObserver {
    /// A model begins to work. The returned value is passed to [`Self::end`].
    fn begin(&mut self) -> u32;
    /// The model has finished.
    fn end(&mut self, begun: u32);
}

/// No observation.
impl WorkObserver for () {
    fn begin(&mut self) -> u32 {
        0
    }

    fn end(&mut self, _begun: u32) {}
}

/// A port that notifies an observer when its model works.
#[derive(Clone, Debug)]
pub struct Metered<Port, Observer> {
    /// The model.
    pub port: Port,
    observer: Observer,
}

impl<Port, Observer: WorkObserver> Metered<Port, Observer> {
    /// A port with an observer.
    pub const fn new(port: Port, observer: Observer) -> Self {
        Self { port, observer }
    }

    #[inline]
    fn observed<T>(&mut self, work: impl FnOnce(&mut Port) -> T) -> T {
        let begun = self.observer.begin();
        let done = work(&mut self.port);
        self.observer.end(begun);
        done
    }
}

impl<Port: SpiErrorType, Observer> SpiErrorType for Metered<Port, Observer> {
    type Error = Port::Error;
}

impl<Port: SpiDevice, Observer: WorkObserver> SpiDevice for Metered<Port, Observer> {
    fn transaction(&mut self, operations: &mut [Operation<'_, u8>]) -> Result<(), Self::Error> {
        self.observed(|port| port.transaction(operations))
    }
}

/// A serial port with an observer. It is separate from [`Metered`] because the error types of both traits
/// have the same name.
#[derive(Clone, Debug)]
pub struct MeteredUart<Port, Observer>(pub Metered<Port, Observer>);

impl<Port, Observer: WorkObserver> MeteredUart<Port, Observer> {
    /// A port with an observer.
    pub const fn new(port: Port, observer: Observer) -> Self {
        Self(Metered::new(port, observer))
    }
}

impl<Port: ErrorType, Observer> ErrorType for MeteredUart<Port, Observer> {
    type Error = Port::Error;
}

impl<Port: ReadReady, Observer: WorkObserver> ReadReady for MeteredUart<Port, Observer> {
    fn read_ready(&mut self) -> Result<bool, Self::Error> {
        self.0.observed(ReadReady::read_ready)
    }
}

impl<Port: Read, Observer: WorkObserver> Read for MeteredUart<Port, Observer> {
    fn read(&mut self, buffer: &mut [u8]) -> Result<usize, Self::Error> {
        self.0.observed(|port| port.read(buffer))
    }
}

impl<Port: WriteReady, Observer: WorkObserver> WriteReady for MeteredUart<Port, Observer> {
    fn write_ready(&mut self) -> Result<bool, Self::Error> {
        self.0.observed(WriteReady::write_ready)
    }
}

impl<Port: Write, Observer: WorkObserver> Write for MeteredUart<Port, Observer> {
    fn write(&mut self, bytes: &[u8]) -> Result<usize, Self::Error> {
        self.0.observed(|port| port.write(bytes))
    }

    fn flush(&mut self) -> Result<(), Self::Error> {
        self.0.observed(Write::flush)
    }
}
