// Runs what a manifest asks for and no file holds yet. A whole file under its key is done: files
// appear whole or not at all, and know their own checksum. Any number of processes may work on one
// folder, on the same rows too: what two of them make is the same.
#pragma once

#include <string>
#include <vector>

#include "campaign/crew.h"
#include "campaign/folder.h"
#include "campaign/frame_counts.h"
#include "campaign/manifest.h"
#include "campaign/task_slice.h"

namespace pleat::campaign {

struct RunOptions {
  std::string folder;
  uint64_t seed = 1;
  int threads = 0;  // 0: all cores, and no more than max_memory_mb lets
  TaskSlice slice;
  Limits limits;
};

struct RunReport : FrameCounts {  // of all chains, made now or before
  int made = 0, kept = 0;         // garments or chains: made now, found done
  int failed = 0;                 // of them came to nothing, now or before
  bool is_interrupted = false;    // by the user: run again to go on
};

// Reads the body, every motion and every shape as the runs below will, so that a bad one is known
// before hours of work. Returns the frames of each motion. InputError.
std::vector<int> check_inputs(const Campaign& campaign);

// The designs of the slice's rows, sewn and settled on the mean body: folder/garments/<key>.h5.
RunReport settle_garments(const Campaign& campaign, const Manifest& manifest,
                          const RunOptions& options);

// The slice's chains: folder/shards/<key>.h5. A chain takes one thread; which one, in which order,
// and after how many interruptions changes no bit. One that comes to nothing is recorded in
// failures/ and left alone from then on. ResourceError where disk or memory is short.
RunReport run_chains(const Campaign& campaign, const Manifest& manifest, const RunOptions& options);

// Bytes that the chain's shard takes, about.
double shard_bytes(int frames, int garment_vertices, int checkpoint_frames);

}  // namespace pleat::campaign
