//! The state of a run as bytes. Hit points are not stored: the same random numbers find them again.

use gi_core::bytes::{Reader, Writer};

use crate::Ppm;
use crate::error::Moments;
use crate::initial::AtBounds;
use crate::region::Region;
use crate::shows::{Row, Trace};
use crate::statistics::{Counts, Statistics};

impl Ppm<'_> {
    pub(crate) fn write_state(&self) -> Vec<u8> {
        let mut w = Writer::default();
        w.u32(self.needs_moments().into());
        let Counts { passes, paths, stored, contributed, error } = self.counts;
        w.u32(passes);
        [paths, stored, contributed].into_iter().for_each(|n| w.u64(n));
        w.f64(error);
        [self.at_bounds.least, self.at_bounds.most].into_iter().for_each(|n| w.u64(n));
        self.pixels.rows().for_each(|r| r.write(&mut w));
        w.u32(self.traces.len() as u32);
        self.traces.iter().for_each(|t| t.write(&mut w));
        w.into_bytes()
    }

    /// Read a state. Unless the run `goes_on` from it, it may be that of another seed or with other pictures.
    pub(crate) fn read_state(&mut self, state: &[u8], goes_on: bool) -> Result<(), String> {
        let mut r = Reader::new(state);
        if r.u32()? != u32::from(self.needs_moments()) && goes_on {
            return Err("one of the two runs estimates its error, the other does not: give both or neither --stop-at-error or --show error".into());
        }
        let passes = r.u32()?;
        let [paths, stored, contributed] = [r.u64()?, r.u64()?, r.u64()?];
        let counts = Counts { passes, paths, stored, contributed, error: r.f64()? };
        let at_bounds = AtBounds { least: r.u64()?, most: r.u64()? };
        let mut pixels = self.pixels.clone();
        let mut damage = Ok(());
        pixels.for_each_row_mut(|region| {
            if damage.is_ok() {
                damage = region.read(&mut r, goes_on);
            }
        });
        damage?;
        let traces = (0..r.u32()?).map(|_| Trace::read(&mut r)).collect::<Result<Vec<_>, _>>()?;
        r.end()?;
        if goes_on && !traces.iter().map(|t| t.at).eq(self.traces.iter().map(|t| t.at)) {
            return Err("it traces other pixels".into());
        }
        self.counts = counts.after(&self.counts);
        (self.at_bounds, self.pixels) = (at_bounds, pixels);
        if goes_on {
            self.traces = traces;
        }
        Ok(())
    }
}

impl Statistics {
    fn write(&self, w: &mut Writer) {
        w.f64s(&[self.radius, self.photons]);
        w.f64s(&self.flux);
    }

    fn read(r: &mut Reader) -> Result<Self, String> {
        Ok(Statistics { radius: r.f64()?, photons: r.f64()?, flux: r.f64s()? })
    }
}

impl Region {
    fn write(&self, w: &mut Writer) {
        self.statistics.write(w);
        w.f64(self.initial);
        w.u64(self.pass.photons);
        self.moments.write(w);
        w.u32(self.hits.len() as u32);
        self.hits.iter().for_each(|hit| hit.statistics.write(w));
    }

    /// Unless the run `goes_on` from them, the hit points may be those of another seed; they are not kept.
    fn read(&mut self, r: &mut Reader, goes_on: bool) -> Result<(), String> {
        self.statistics = Statistics::read(r)?;
        self.initial = r.f64()?;
        self.pass.photons = r.u64()?;
        self.moments = Moments::read(r)?;
        let hits = r.u32()?;
        if !goes_on {
            return (0..hits).try_for_each(|_| Statistics::read(r).map(|_| ()));
        }
        if hits as usize != self.hits.len() {
            return Err("it has other hit points".into());
        }
        self.hits.iter_mut().try_for_each(|hit| {
            hit.statistics = Statistics::read(r)?;
            Ok(())
        })
    }
}

impl Trace {
    fn write(&self, w: &mut Writer) {
        self.at.into_iter().for_each(|n| w.u64(n as u64));
        w.u32(self.rows.len() as u32);
        for Row { pass, radius, photons, found, radiance } in &self.rows {
            w.u32(*pass);
            w.f64s(&[*radius, *photons]);
            w.u64(*found);
            w.f64s(radiance);
        }
    }

    fn read(r: &mut Reader) -> Result<Self, String> {
        let at = [r.u64()? as usize, r.u64()? as usize];
        let row = |r: &mut Reader| {
            let pass = r.u32()?;
            let (radius, photons) = (r.f64()?, r.f64()?);
            Ok(Row { pass, radius, photons, found: r.u64()?, radiance: r.f64s()? })
        };
        let rows = (0..r.u32()?).map(|_| row(r)).collect::<Result<Vec<_>, String>>()?;
        Ok(Trace { at, rows })
    }
}
