//! The base's side: what a controller answers.

use super::frames::Request;
use super::{PACKET_PAUSE_S, status};
use crate::base::peer::{OrderBook, Orders};
use crate::base::{BaseError, BaseSettings, Machine, Peer};
use crate::robot::TrackSpeeds;

/// A `RoboClaw`. Its watchdog is off at power-on, and counts every byte as a sign of life.
#[derive(Clone, Debug)]
pub struct RoboClawPeer {
    settings: BaseSettings,
    received: Vec<u8>,
    requests: Vec<Request>,
    last_byte_s: f64,
    watchdog_tenths: u8,
    set: [i32; 2],
    orders: OrderBook,
}

impl RoboClawPeer {
    /// A controller that was just switched on, of a machine that is as the settings say.
    ///
    /// # Errors
    /// Those of [`BaseSettings::validate`].
    pub fn new(settings: BaseSettings) -> Result<Self, BaseError> {
        settings.validate()?;
        Ok(Self {
            settings,
            received: Vec::new(),
            requests: Vec::new(),
            last_byte_s: f64::NEG_INFINITY,
            watchdog_tenths: 0,
            set: [0, 0],
            orders: OrderBook::default(),
        })
    }

    fn answer(&mut self, request: Request, machine: &Machine) -> Vec<u8> {
        let settings = &self.settings;
        let counted = |number: [u8; 4]| [&number[..], &[0]].concat();
        let data = match request {
            Request::SetTimeout(tenths) => {
                self.watchdog_tenths = tenths;
                return vec![0xFF];
            }
            Request::Drive(speeds) => {
                self.set = speeds;
                self.orders.command(speeds == [0, 0]);
                return vec![0xFF];
            }
            Request::GetTimeout => vec![self.watchdog_tenths],
            Request::Encoder { second } => {
                let counts = settings.channel_counts(machine.ticks);
                counted(counts[usize::from(second)].to_be_bytes())
            }
            Request::Speed { second } => {
                let rate = settings.channel_rates(&machine.speeds)[usize::from(second)];
                counted((rate.round() as i32).to_be_bytes())
            }
            Request::Battery => {
                let decivolts = (machine.battery_v * 10.0).round() as u16;
                decivolts.to_be_bytes().to_vec()
            }
            Request::Status => {
                let bits = status::write(settings, machine.button_pressed, machine.faults);
                bits.to_be_bytes()[4 - settings.roboclaw.status_bytes..].to_vec()
            }
        };
        request.answer(settings.roboclaw.address, data)
    }
}

impl Peer for RoboClawPeer {
    fn receive(&mut self, bytes: &[u8], now_s: f64) {
        if bytes.is_empty() {
            return;
        }
        if now_s - self.last_byte_s > PACKET_PAUSE_S {
            self.received.clear();
        }
        self.last_byte_s = now_s;
        self.received.extend_from_slice(bytes);
        loop {
            match Request::decode(&self.received, self.settings.roboclaw.address) {
                Ok(Some((request, length))) => {
                    self.requests.push(request);
                    self.received.drain(..length);
                }
                Ok(None) => return,
                // Silence is the answer, and the host's pause the way out.
                Err(_) => {
                    self.received.clear();
                    return;
                }
            }
        }
    }

    fn step(&mut self, now_s: f64, machine: &Machine, line: &mut Vec<u8>) -> TrackSpeeds {
        for request in std::mem::take(&mut self.requests) {
            line.extend(self.answer(request, machine));
        }
        let watchdog_s = f64::from(self.watchdog_tenths) / 10.0;
        let is_silent = self.watchdog_tenths > 0 && now_s - self.last_byte_s >= watchdog_s;
        self.orders.starved(is_silent && self.set != [0, 0]);
        if is_silent {
            // The set speeds are gone, not only held back: questions that come later do not start the motors again.
            self.set = [0, 0];
        }
        if machine.button_pressed {
            TrackSpeeds::default()
        } else {
            self.settings.track_speeds(self.set.map(f64::from))
        }
    }

    fn orders(&self) -> Orders {
        self.orders.orders()
    }
}
