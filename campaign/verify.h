// Drapes made again from what their shards say, and compared bit for bit.
#pragma once

#include <string>
#include <vector>

#include "campaign/manifest.h"
#include "campaign/run_tasks.h"

namespace pleat::campaign {

// Frames of a chain from one checkpoint to the next.
struct Piece {
  int chain = 0;  // row of the manifest
  int first_frame = 0, frames = 0;
};

// Of the chains that are done: all pieces, or `sample` of them, drawn by `seed`.
std::vector<Piece> pieces_of(const Manifest& manifest, const std::string& folder, int sample,
                             uint64_t seed);

struct Difference {
  Piece piece;
  int frame = 0;          // the first that differs
  bool is_timed = false;  // behind a frame that ran out of time, whose bits the clock decided
};

struct VerifyReport {
  int pieces = 0;
  int64_t frames = 0;
  std::vector<Difference> differences;
  std::vector<std::string> machines;  // others that made the shards
  bool is_interrupted = false;
};

// InputError where a garment or shard is missing.
VerifyReport verify(const Campaign& campaign, const Manifest& manifest, const RunOptions& options,
                    const std::vector<Piece>& pieces);

// One frame made again, with the piece that holds it up to there.
struct FrameAgain {
  garment::Certificate before, now;
  bool is_same = false;  // every bit of it
};
FrameAgain run_frame_again(const Campaign& campaign, const Manifest& manifest,
                           const RunOptions& options, int chain, int frame);

// A chain from its beginning to `frame`, its garment too, made from the campaign's inputs alone.
// The clip is empty where the user interrupted.
struct Remade {
  garment::Garment garment;
  garment::Clip clip;  // positions rounded to float, as a shard has them
};
Remade remake(const Campaign& campaign, const Manifest& manifest, const RunOptions& options,
              int chain, int frame);

}  // namespace pleat::campaign
