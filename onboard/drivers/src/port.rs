//! Reads what has arrived on a UART.

use embedded_io::{Read, ReadReady};

use crate::error::SensorError;

/// Takes the bytes that have arrived, at most as many as `bytes` holds, without waiting. Returns their
/// number.
///
/// # Errors
/// [`SensorError::Bus`] when the port reports an error.
pub(crate) fn receive<Port: Read + ReadReady>(
    port: &mut Port,
    bytes: &mut [u8],
) -> Result<usize, SensorError> {
    let mut arrived = 0;
    while let Some(room) = bytes.get_mut(arrived..)
        && !room.is_empty()
        && port.read_ready().map_err(|_| SensorError::Bus)?
    {
        match port.read(room).map_err(|_| SensorError::Bus)? {
            0 => break,
            count => arrived += count,
        }
    }
    Ok(arrived)
}
