//! The files of a data set.

mod meta;

use std::path::{Path, PathBuf};

use camera::{Picture, observe};
use cell_model::Data;

use crate::ExportError;
use crate::episode::Episode;
use crate::features::{Vectors, vectors};
use crate::pictures::{Storage, Video, png};
use crate::stats::Stats;
use crate::table::{Column, TableFile, Values};

/// Sizes at which a file of the format ends (bytes), and files of a chunk.
// The defaults of lerobot.
const DATA_BYTES: usize = 100 << 20;
const VIDEO_BYTES: u64 = 200 << 20;
const CHUNK_FILES: i64 = 1000;
/// Pictures of an episode that its statistics are of.
const SAMPLED: usize = 100;

/// Number of a file in its chunk.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Place {
    pub(crate) chunk: i64,
    pub(crate) file: i64,
}

impl Place {
    fn next(self) -> Self {
        match self.file + 1 {
            CHUNK_FILES => Self {
                chunk: self.chunk + 1,
                file: 0,
            },
            file => Self { file, ..self },
        }
    }

    fn path(self, dir: &Path, ending: &str) -> PathBuf {
        dir.join(format!(
            "chunk-{:03}/file-{:03}.{ending}",
            self.chunk, self.file
        ))
    }
}

/// An episode that was written.
pub(crate) struct Written {
    pub(crate) task: usize,
    pub(crate) frames: usize,
    /// Number of its first frame over all episodes.
    pub(crate) first: usize,
    pub(crate) data: Place,
    /// By camera: its file, and the number of its first frame in it.
    pub(crate) videos: Vec<(Place, u64)>,
    /// By feature.
    pub(crate) stats: Vec<(String, Stats)>,
    pub(crate) run: String,
    pub(crate) seed: u64,
    pub(crate) policy: String,
    pub(crate) state_hash: String,
    pub(crate) ticks: u64,
    pub(crate) grip_force: f64,
    pub(crate) success: bool,
}

/// What all episodes have in common.
pub(crate) struct Common {
    pub(crate) demo: String,
    pub(crate) rate_hz: u32,
    pub(crate) robot: String,
    /// Names of the numbers of each vector.
    pub(crate) vectors: Vec<(&'static str, Vec<String>)>,
    /// Name, width and height of each camera.
    pub(crate) cameras: Vec<(String, u32, u32)>,
    pub(crate) storage: Storage,
}

struct Writer<'a> {
    out: &'a Path,
    cameras: &'a [String],
    storage: Storage,
    common: Option<Common>,
    tasks: Vec<String>,
    episodes: Vec<Written>,
    frames: usize,
    data: Option<TableFile>,
    data_place: Place,
    /// By camera.
    videos: Vec<Option<Video>>,
    video_places: Vec<Place>,
}

/// Writes the data set; a sentence about it.
pub(crate) fn write(
    data: &Data,
    out: &Path,
    files: &[PathBuf],
    cameras: &[String],
) -> Result<String, ExportError> {
    // Readers take all files below `data`, also those of an older data set. A directory that cannot
    // be listed does not exist yet, or the first write fails.
    let is_used = std::fs::read_dir(out).is_ok_and(|mut entries| entries.next().is_some());
    if is_used {
        return Err(ExportError::episode(
            out,
            "it is not empty; name a new directory",
        ));
    }
    let mut writer = Writer {
        out,
        cameras,
        storage: Storage::here(),
        common: None,
        tasks: Vec::new(),
        episodes: Vec::new(),
        frames: 0,
        data: None,
        data_place: Place::default(),
        videos: cameras.iter().map(|_| None).collect(),
        video_places: vec![Place::default(); cameras.len()],
    };
    for file in files {
        let episode = Episode::read(file, data)?;
        writer.add(&episode, file)?;
    }
    writer.finish()
}

impl Writer<'_> {
    fn add(&mut self, episode: &Episode, file: &Path) -> Result<(), ExportError> {
        let vectors = vectors(episode);
        let pictures = self.pictures(episode)?;
        self.check(episode, &vectors, &pictures, file)?;
        let index = self.episodes.len();
        let sentence = &episode.cell.description;
        let known = self.tasks.iter().position(|task| task == sentence);
        let task = known.unwrap_or_else(|| {
            self.tasks.push(sentence.clone());
            self.tasks.len() - 1
        });
        let mut stats = Vec::new();
        let mut columns: Vec<Column> = Vec::new();
        for one in vectors {
            let width = one.names.len();
            stats.push((one.key.to_owned(), Stats::of(&one.numbers, width)));
            columns.push(Column::list(one.key, width, Values::Float(one.numbers)));
        }
        let frames = episode.frames.len();
        for (column, numbers) in self.counted(episode.rate_hz, frames, index, task) {
            stats.push((column.name.clone(), Stats::of(&numbers, 1)));
            columns.push(column);
        }
        let mut videos = Vec::new();
        for (camera, pictures) in pictures.iter().enumerate() {
            let key = camera_key(self.cameras.get(camera).map_or("", String::as_str));
            let step = (pictures.len() / SAMPLED).max(1);
            let sampled = pictures.iter().step_by(step).map(|one| one.rgb.as_slice());
            stats.push((key.clone(), Stats::of_pictures(&sampled)));
            match self.storage {
                Storage::Png => {
                    let bytes: Result<Vec<_>, _> = pictures.iter().map(png).collect();
                    let bytes = bytes.map_err(|error| ExportError::io(file, error))?;
                    columns.push(Column::one(&key, Values::Pictures(bytes)));
                }
                Storage::Video => {
                    videos.push(self.film(camera, &key, pictures, episode.rate_hz)?);
                }
            }
        }
        let data = self.add_rows(&columns)?;
        self.episodes.push(Written {
            task,
            frames,
            first: self.frames,
            data,
            videos,
            stats,
            run: serde_json::to_string(&episode.spec).unwrap_or_default(),
            seed: episode.spec.seed,
            policy: episode.spec.policy.clone(),
            state_hash: format!("{:016x}", episode.end.state_hash),
            ticks: episode.end.header.tick,
            grip_force: episode.grip_force,
            success: episode.success,
        });
        self.frames += frames;
        Ok(())
    }

    /// Pictures of all frames, by camera.
    fn pictures(&self, episode: &Episode) -> Result<Vec<Vec<Picture>>, ExportError> {
        let mut all: Vec<Vec<Picture>> = self.cameras.iter().map(|_| Vec::new()).collect();
        for frame in &episode.frames {
            let seen = observe(&episode.cell, &frame.state, self.cameras)?;
            for (camera, picture) in all.iter_mut().zip(seen) {
                camera.push(picture);
            }
        }
        Ok(all)
    }

    /// All episodes of a data set have the same features.
    fn check(
        &mut self,
        episode: &Episode,
        vectors: &[Vectors],
        pictures: &[Vec<Picture>],
        file: &Path,
    ) -> Result<(), ExportError> {
        let names: Vec<_> = vectors
            .iter()
            .map(|one| (one.key, one.names.clone()))
            .collect();
        if let Some(common) = &self.common {
            let same = (&common.demo, common.rate_hz) == (&episode.spec.demo, episode.rate_hz);
            if same && common.vectors == names {
                return Ok(());
            }
            let why = format!(
                "it is of the cell `{}` at {} Hz, the first recording of `{}` at {} Hz; a data set has one cell and one rate",
                episode.spec.demo, episode.rate_hz, common.demo, common.rate_hz
            );
            return Err(ExportError::episode(file, why));
        }
        let sizes = self.cameras.iter().zip(pictures).map(|(name, pictures)| {
            let (width, height) = pictures
                .first()
                .map_or((0, 0), |one| (one.width, one.height));
            (name.clone(), width, height)
        });
        self.common = Some(Common {
            demo: episode.spec.demo.clone(),
            rate_hz: episode.rate_hz,
            robot: episode
                .cell
                .arms
                .first()
                .map_or_else(String::new, |arm| arm.robot.name.clone()),
            vectors: names,
            cameras: sizes.collect(),
            storage: self.storage,
        });
        Ok(())
    }

    /// The columns that count, with their numbers.
    fn counted(
        &self,
        rate_hz: u32,
        frames: usize,
        index: usize,
        task: usize,
    ) -> Vec<(Column, Vec<f32>)> {
        let times = (0..frames).map(|frame| single(frame as f64 / f64::from(rate_hz)));
        let times: Vec<f32> = times.collect();
        let timestamp = Column::one("timestamp", Values::Float(times.clone()));
        let whole = |name: &str, numbers: Vec<usize>| {
            let approximate = numbers.iter().map(|number| single(*number as f64));
            let approximate = approximate.collect();
            let numbers = numbers.into_iter().map(whole_number).collect();
            (Column::one(name, Values::Int(numbers)), approximate)
        };
        vec![
            (timestamp, times),
            whole("frame_index", (0..frames).collect()),
            whole("episode_index", vec![index; frames]),
            whole("index", (self.frames..self.frames + frames).collect()),
            whole("task_index", vec![task; frames]),
        ]
    }

    fn add_rows(&mut self, columns: &[Column]) -> Result<Place, ExportError> {
        if self
            .data
            .as_ref()
            .is_some_and(|file| file.bytes() >= DATA_BYTES)
            && let Some(full) = self.data.take()
        {
            full.close(None)?;
            self.data_place = self.data_place.next();
        }
        let mut file = if let Some(file) = self.data.take() {
            file
        } else {
            let path = self.data_place.path(&self.out.join("data"), "parquet");
            TableFile::create(&path, columns)?
        };
        file.add(columns)?;
        self.data = Some(file);
        Ok(self.data_place)
    }

    /// Adds the pictures of an episode to the video of a camera; returns the file and the number of
    /// the first frame in it.
    fn film(
        &mut self,
        camera: usize,
        key: &str,
        pictures: &[Picture],
        rate_hz: u32,
    ) -> Result<(Place, u64), ExportError> {
        let (Some(video), Some(place), Some(first)) = (
            self.videos.get_mut(camera),
            self.video_places.get_mut(camera),
            pictures.first(),
        ) else {
            return Ok((Place::default(), 0));
        };
        if video
            .as_ref()
            .is_some_and(|video| video.bytes() >= VIDEO_BYTES)
            && let Some(full) = video.take()
        {
            full.close()?;
            *place = place.next();
        }
        let mut file = if let Some(file) = video.take() {
            file
        } else {
            let path = place.path(&self.out.join("videos").join(key), "mp4");
            Video::create(&path, (first.width, first.height), rate_hz)?
        };
        let begins = file.frames;
        for picture in pictures {
            file.add(picture)?;
        }
        *video = Some(file);
        Ok((*place, begins))
    }

    fn finish(self) -> Result<String, ExportError> {
        if let Some(file) = self.data {
            // A file of Parquet ends with its footer: without `close` it cannot be read.
            file.close(None)?;
        }
        for video in self.videos.into_iter().flatten() {
            video.close()?;
        }
        let Some(common) = self.common else {
            return Err(ExportError::episode(self.out, "no recording was named"));
        };
        meta::write(self.out, &common, &self.tasks, &self.episodes)?;
        let pictures = match (self.cameras.len(), self.storage) {
            (0, _) => "no pictures",
            (_, Storage::Video) => "pictures as h264 without loss",
            (_, Storage::Png) => "pictures as PNG, since no ffmpeg with libx264rgb is on PATH",
        };
        let episodes = self.episodes.len();
        Ok(format!(
            "{episodes} episodes, {} frames, {pictures}",
            self.frames
        ))
    }
}

/// A count as a number of a table.
pub(crate) fn whole_number(count: usize) -> i64 {
    i64::try_from(count).unwrap_or(i64::MAX)
}

/// Name of the feature of a camera.
pub(crate) fn camera_key(name: &str) -> String {
    format!("observation.images.{name}")
}

#[allow(clippy::cast_possible_truncation, reason = "rounds")]
fn single(number: f64) -> f32 {
    number as f32
}
