//! The picture in another program while it is made: tiles of all layers, sent as they change, by the protocol of the viewer tev.

use std::net::{TcpStream, ToSocketAddrs};
use std::time::Duration;

use gi_core::image_io::Layers;
use tev_client::{PacketCreateImage, PacketUpdateImage, TevClient};

use crate::Failure;

/// The port that tev listens on.
const PORT: u16 = 14158;
/// Side of the tiles that are sent, in pixels.
const TILE: usize = 128;
/// How long a viewer may take to answer, and to take what is sent.
const PATIENCE: Duration = Duration::from_secs(3);

/// A connection with a viewer.
pub(crate) struct Display {
    client: TevClient,
    /// The picture's name in the viewer.
    name: String,
    /// What the viewer has.
    sent: Option<Layers>,
}

impl Display {
    /// Connect with the viewer at HOST:PORT, or at HOST on tev's port.
    pub(crate) fn connect(address: &str, name: String) -> Result<Self, Failure> {
        let cannot = |e: &dyn std::fmt::Display| {
            Failure::Input(format!(
                "error: --display-server {address}: {e}; start the viewer first, or name another address"
            ))
        };
        let with_port = format!("{address}:{PORT}");
        let has_port =
            address.rsplit_once(':').is_some_and(|(_, port)| port.parse::<u16>().is_ok());
        let address = if has_port { address } else { with_port.as_str() };
        let mut places = address.to_socket_addrs().map_err(|e| cannot(&e))?;
        let place = places.next().ok_or_else(|| cannot(&"no such address"))?;
        let socket = TcpStream::connect_timeout(&place, PATIENCE).map_err(|e| cannot(&e))?;
        socket.set_write_timeout(Some(PATIENCE)).map_err(|e| cannot(&e))?;
        Ok(Display { client: TevClient::wrap(socket), name, sent: None })
    }

    /// Send the tiles that have changed.
    pub(crate) fn send(&mut self, layers: Layers) -> Result<(), Failure> {
        let sent = self.send_tiles(&layers);
        self.sent = Some(layers);
        sent.map_err(|e| Failure::Other(format!("--display-server: {e}")))
    }

    fn send_tiles(&mut self, layers: &Layers) -> std::io::Result<()> {
        let names: Vec<&str> = layers.channels.iter().map(|(name, _)| name.as_str()).collect();
        let is_new = self.sent.as_ref().is_none_or(|sent| {
            !sent.channels.iter().map(|(name, _)| name.as_str()).eq(names.iter().copied())
        });
        if is_new {
            self.client.send(PacketCreateImage {
                image_name: &self.name,
                grab_focus: true,
                width: layers.width as u32,
                height: layers.height as u32,
                channel_names: &names,
            })?;
        }
        for y in (0..layers.height).step_by(TILE) {
            for x in (0..layers.width).step_by(TILE) {
                let tile = tile(layers, [x, y]);
                if is_new || self.sent.as_ref().is_none_or(|sent| self::tile(sent, [x, y]) != tile)
                {
                    self.send_tile(layers, &names, [x, y], &tile)?;
                }
            }
        }
        Ok(())
    }

    fn send_tile(
        &mut self,
        layers: &Layers,
        names: &[&str],
        [x, y]: [usize; 2],
        tile: &[u32],
    ) -> std::io::Result<()> {
        let (width, height) = (TILE.min(layers.width - x), TILE.min(layers.height - y));
        let offsets: Vec<u64> = (0..names.len()).map(|k| (k * width * height) as u64).collect();
        let data: Vec<f32> = tile.iter().map(|bits| f32::from_bits(*bits)).collect();
        self.client.send(PacketUpdateImage {
            image_name: &self.name,
            grab_focus: false,
            channel_names: names,
            channel_offsets: &offsets,
            channel_strides: &vec![1; names.len()],
            x: x as u32,
            y: y as u32,
            width: width as u32,
            height: height as u32,
            data: &data,
        })
    }
}

/// The bits of a tile, channel by channel.
fn tile(layers: &Layers, [x, y]: [usize; 2]) -> Vec<u32> {
    let (columns, rows) = (x..(x + TILE).min(layers.width), y..(y + TILE).min(layers.height));
    let row = |values: &[f32], y: usize| -> Vec<u32> {
        let first = y * layers.width;
        values[first + columns.start..first + columns.end].iter().map(|v| v.to_bits()).collect()
    };
    let channels = layers.channels.iter();
    channels.flat_map(|(_, values)| rows.clone().flat_map(|y| row(values, y))).collect()
}
