//! The description of a data set: `meta`.

use std::path::Path;

use serde_json::{Map, Value, json};

use super::{
    CHUNK_FILES, Common, DATA_BYTES, Place, VIDEO_BYTES, Written, camera_key, whole_number,
};
use crate::ExportError;
use crate::pictures::Storage;
use crate::stats::Stats;
use crate::table::{Column, TableFile, Values};

/// Names and types of the columns that count.
const COUNTED: [(&str, &str); 5] = [
    ("timestamp", "float32"),
    ("frame_index", "int64"),
    ("episode_index", "int64"),
    ("index", "int64"),
    ("task_index", "int64"),
];

pub(super) fn write(
    out: &Path,
    common: &Common,
    tasks: &[String],
    episodes: &[Written],
) -> Result<(), ExportError> {
    let meta = out.join("meta");
    let columns = episode_columns(common, tasks, episodes);
    table(
        &Place::default().path(&meta.join("episodes"), "parquet"),
        &columns,
        None,
    )?;
    let numbers = (0..tasks.len()).map(whole_number).collect();
    let columns = [
        Column::one("task_index", Values::Int(numbers)),
        Column::one("task", Values::Text(tasks.to_vec())),
    ];
    table(
        &meta.join("tasks.parquet"),
        &columns,
        Some(("pandas", pandas())),
    )?;
    json_file(&meta.join("info.json"), &info(common, tasks, episodes))?;
    json_file(&meta.join("stats.json"), &stats(common, episodes))
}

fn table(
    path: &Path,
    columns: &[Column],
    about: Option<(&str, String)>,
) -> Result<(), ExportError> {
    let mut file = TableFile::create(path, columns)?;
    file.add(columns)?;
    file.close(about)
}

fn json_file(path: &Path, value: &Value) -> Result<(), ExportError> {
    let text = format!("{value:#}\n");
    std::fs::write(path, text).map_err(|error| ExportError::io(path, error))
}

fn info(common: &Common, tasks: &[String], episodes: &[Written]) -> Value {
    let mut features = Map::new();
    for (key, names) in &common.vectors {
        let feature = json!({ "dtype": "float32", "shape": [names.len()], "names": names });
        features.insert((*key).to_owned(), feature);
    }
    for (name, width, height) in &common.cameras {
        features.insert(camera_key(name), camera(common, *width, *height));
    }
    for (key, kind) in COUNTED {
        let feature = json!({ "dtype": kind, "shape": [1], "names": null });
        features.insert(key.to_owned(), feature);
    }
    let has_video = common.storage == Storage::Video && !common.cameras.is_empty();
    let video = "videos/{video_key}/chunk-{chunk_index:03d}/file-{file_index:03d}.mp4";
    json!({
        "codebase_version": "v3.0",
        "robot_type": common.robot,
        "total_episodes": episodes.len(),
        "total_frames": episodes.iter().map(|one| one.frames).sum::<usize>(),
        "total_tasks": tasks.len(),
        "chunks_size": CHUNK_FILES,
        "data_files_size_in_mb": DATA_BYTES >> 20,
        "video_files_size_in_mb": VIDEO_BYTES >> 20,
        "fps": common.rate_hz,
        "splits": { "train": format!("0:{}", episodes.len()) },
        "data_path": "data/chunk-{chunk_index:03d}/file-{file_index:03d}.parquet",
        "video_path": has_video.then_some(video),
        "features": features,
    })
}

fn camera(common: &Common, width: u32, height: u32) -> Value {
    let mut feature = json!({
        "dtype": "image",
        "shape": [height, width, 3],
        "names": ["height", "width", "channels"],
    });
    if common.storage == Storage::Video {
        feature["dtype"] = json!("video");
        feature["info"] = json!({
            "video.height": height,
            "video.width": width,
            "video.codec": "h264",
            // libx264rgb stores its planes in this order; yuv420p would lose colour.
            "video.pix_fmt": "gbrp",
            "video.fps": common.rate_hz,
            "video.channels": 3,
            "has_audio": false,
            "is_depth_map": false,
        });
    }
    feature
}

fn is_camera(key: &str) -> bool {
    key.starts_with("observation.images.")
}

fn stats(common: &Common, episodes: &[Written]) -> Value {
    let keys = common.vectors.iter().map(|(key, _)| (*key).to_owned());
    let cameras = common.cameras.iter().map(|(name, ..)| camera_key(name));
    let counted = COUNTED.iter().map(|(key, _)| (*key).to_owned());
    let all = keys.chain(cameras).chain(counted).map(|key| {
        let parts = episodes.iter().flat_map(|one| &one.stats);
        let parts = parts.filter(|(name, _)| *name == key);
        let parts: Vec<Stats> = parts.map(|(_, stats)| stats.clone()).collect();
        let merged = Stats::merged(&parts).to_json(is_camera(&key));
        (key, merged)
    });
    all.collect::<Map<String, Value>>().into()
}

fn episode_columns(common: &Common, tasks: &[String], episodes: &[Written]) -> Vec<Column> {
    let whole = |name: &str, number: &dyn Fn(&Written) -> i64| {
        Column::one(name, Values::Int(episodes.iter().map(number).collect()))
    };
    let text = |name: &str, text: &dyn Fn(&Written) -> String| {
        Column::one(name, Values::Text(episodes.iter().map(text).collect()))
    };
    let number = |name: &str, number: &dyn Fn(&Written) -> f64| {
        Column::one(name, Values::Double(episodes.iter().map(number).collect()))
    };
    let sentences = episodes
        .iter()
        .filter_map(|one| tasks.get(one.task).cloned());
    let indices = (0..episodes.len()).map(whole_number).collect();
    let success = episodes.iter().map(|one| one.success).collect();
    let mut columns = vec![
        Column::one("episode_index", Values::Int(indices)),
        Column::list("tasks", 1, Values::Text(sentences.collect())),
        whole("length", &|one| whole_number(one.frames)),
        whole("dataset_from_index", &|one| whole_number(one.first)),
        whole("dataset_to_index", &|one| {
            whole_number(one.first + one.frames)
        }),
        whole("data/chunk_index", &|one| one.data.chunk),
        whole("data/file_index", &|one| one.data.file),
        // `write` puts all episodes into one file.
        whole("meta/episodes/chunk_index", &|_| 0),
        whole("meta/episodes/file_index", &|_| 0),
        Column::one("success", Values::Bool(success)),
        whole("robocell/seed", &|one| {
            // A larger seed does not fit; a replay takes it from `robocell/run`.
            i64::try_from(one.seed).unwrap_or(-1)
        }),
        text("robocell/cell", &|_| common.demo.clone()),
        text("robocell/policy", &|one| one.policy.clone()),
        text("robocell/version", &|_| {
            env!("CARGO_PKG_VERSION").to_owned()
        }),
        text("robocell/state_hash", &|one| one.state_hash.clone()),
        whole("robocell/ticks", &|one| {
            i64::try_from(one.ticks).unwrap_or(i64::MAX)
        }),
        number("robocell/grip_force_n", &|one| one.grip_force),
        text("robocell/run", &|one| one.run.clone()),
    ];
    columns.extend(video_columns(common, episodes));
    columns.extend(stats_columns(episodes));
    columns
}

/// Where the pictures of each episode are in the videos.
fn video_columns(common: &Common, episodes: &[Written]) -> Vec<Column> {
    if common.storage != Storage::Video {
        return Vec::new();
    }
    let rate = f64::from(common.rate_hz);
    let of_camera = |(index, name): (usize, &String)| {
        let key = format!("videos/{}", camera_key(name));
        let video = |one: &Written| one.videos.get(index).copied().unwrap_or_default();
        let whole = |name: &str, number: &dyn Fn(&Written) -> i64| {
            let numbers = episodes.iter().map(number).collect();
            Column::one(&format!("{key}/{name}"), Values::Int(numbers))
        };
        let time = |name: &str, frame: &dyn Fn(&Written) -> f64| {
            let times = episodes.iter().map(|one| frame(one) / rate).collect();
            Column::one(&format!("{key}/{name}"), Values::Double(times))
        };
        [
            whole("chunk_index", &|one| video(one).0.chunk),
            whole("file_index", &|one| video(one).0.file),
            time("from_timestamp", &|one| video(one).1 as f64),
            time("to_timestamp", &|one| {
                video(one).1 as f64 + one.frames as f64
            }),
        ]
    };
    let names = common.cameras.iter().map(|(name, ..)| name);
    names.enumerate().flat_map(of_camera).collect()
}

fn stats_columns(episodes: &[Written]) -> Vec<Column> {
    let mut columns = Vec::new();
    // Those of the first: `Writer::check` refuses an episode with other features.
    let keys = episodes.first().map(|one| &one.stats);
    for (at, (key, _)) in keys.into_iter().flatten().enumerate() {
        let of = |one: &Written| one.stats.get(at).map(|(_, stats)| stats.clone());
        let all: Vec<Stats> = episodes.iter().filter_map(of).collect();
        let lists = all.first().map(Stats::lists).unwrap_or_default();
        for (list, (name, values)) in lists.iter().enumerate() {
            let width = values.len();
            let values = all.iter().flat_map(|stats| {
                let lists = stats.lists();
                lists
                    .get(list)
                    .map(|(_, values)| values.to_vec())
                    .unwrap_or_default()
            });
            let (name, values) = (
                format!("stats/{key}/{name}"),
                Values::Double(values.collect()),
            );
            columns.push(if is_camera(key) {
                Column::nested(&name, width, values)
            } else {
                Column::list(&name, width, values)
            });
        }
        let counts = all.iter().map(|stats| whole_number(stats.count)).collect();
        columns.push(Column::list(
            &format!("stats/{key}/count"),
            1,
            Values::Int(counts),
        ));
    }
    columns
}

/// Says which column of `tasks.parquet` is its index: the reader looks sentences up by it.
fn pandas() -> String {
    let column = |name: &str, kind: &str, numpy: &str| {
        json!({
            "name": name, "field_name": name, "pandas_type": kind, "numpy_type": numpy,
            "metadata": null,
        })
    };
    json!({
        "index_columns": ["task"],
        "column_indexes": [],
        "columns": [column("task_index", "int64", "int64"), column("task", "unicode", "object")],
        "creator": { "library": "robocell", "version": env!("CARGO_PKG_VERSION") },
        "pandas_version": "2.3.3",
    })
    .to_string()
}
