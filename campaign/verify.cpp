#include "campaign/verify.h"

#include <algorithm>
#include <filesystem>
#include <mutex>
#include <set>

#include "body/body_file.h"
#include "core/error.h"
#include "core/hdf5_file.h"
#include "core/progress.h"
#include "core/random.h"
#include "garment/checked_arrays.h"
#include "garment/clip.h"
#include "garment/garment_file.h"

namespace pleat::campaign {
namespace {

// What a chain is made of, read anew.
struct Ingredients {
  garment::Garment garment;
  body::Motion motion;
  garment::Fabric fabric;
  garment::Clip shard;  // the piece
};

Ingredients ingredients_of(const Campaign& campaign, const Manifest& manifest,
                           const std::string& folder, const body::BodyModel& model,
                           const Piece& piece) {
  const Chain& chain = manifest.chains[piece.chain];
  const MotionSource& source = campaign.motions[chain.motion];
  Ingredients result{
      garment::read_garment(garment_path(folder, manifest.garment_keys[chain.design])),
      body::load_motion(source.file, model, source.config), fabric_of(campaign, chain),
      garment::read_clip_frames(shard_path(folder, chain.key), piece.first_frame, piece.frames)};
  result.motion.name = source.name;
  return result;
}

// The piece's first frames, made again; none where it was stopped.
garment::Clip make_again(const Campaign& campaign, const body::BodyModel& model,
                         const Ingredients& made_of, const Chain& chain, int frames,
                         sim::Supervision supervision) {
  const int first_frame = made_of.shard.first_frame;
  const garment::ClipState* from = nullptr;
  for (const garment::ClipState& state : made_of.shard.states)
    if (state.frame == first_frame) from = &state;
  body::Motion motion = made_of.motion;
  motion.frames.resize(std::min(motion.frames.size(), static_cast<size_t>(first_frame + frames)));
  garment::Clip again;
  supervision.on_part = [&](const garment::Clip& part) { again = part; };
  sim::simulate_parts(made_of.garment, model, campaign.shapes[chain.shape], motion, made_of.fabric,
                      campaign.simulation, from, supervision);
  return again;
}

// Whether frame t of the piece has the same bits, both by what its shard says that it holds and by
// what it holds.
bool is_same(const garment::Clip& again, const garment::Clip& shard, int t) {
  const std::string hash = garment::frame_hash(again, t);
  return hash == shard.frame_sha256[t] && hash == garment::frame_hash(shard, t);
}

std::vector<Piece> pieces_of_chain(const std::string& path, int chain) {
  const Hdf5File file = Hdf5File::open(path);
  const int frames =
      static_cast<int>(garment::checked_dims(file, "positions", {-1, -1, 3}).front());
  std::vector<int> starts = file.read<int>("states/frame");
  starts.insert(starts.begin(), 0);
  starts.push_back(frames);
  std::vector<Piece> pieces;
  for (size_t k = 0; k + 1 < starts.size(); ++k) {
    if (starts[k + 1] <= starts[k])
      throw InputError(path + ": states/frame: is no rising list of frames of the clip");
    pieces.push_back({chain, starts[k], starts[k + 1] - starts[k]});
  }
  return pieces;
}

}  // namespace

std::vector<Piece> pieces_of(const Manifest& manifest, const std::string& folder, int sample,
                             uint64_t seed) {
  std::vector<Piece> pieces;
  for (size_t c = 0; c < manifest.chains.size(); ++c) {
    const std::string path = shard_path(folder, manifest.chains[c].key);
    if (!std::filesystem::exists(path)) continue;
    const std::vector<Piece> more = pieces_of_chain(path, static_cast<int>(c));
    pieces.insert(pieces.end(), more.begin(), more.end());
  }
  if (sample <= 0 || static_cast<size_t>(sample) >= pieces.size()) return pieces;
  RandomStream random(seed, "verify");
  std::vector<Piece> drawn;
  for (int k = 0; k < sample; ++k) {
    const size_t i = k + random.below(pieces.size() - k);
    std::swap(pieces[k], pieces[i]);
    drawn.push_back(pieces[k]);
  }
  return drawn;
}

VerifyReport verify(const Campaign& campaign, const Manifest& manifest, const RunOptions& options,
                    const std::vector<Piece>& pieces) {
  VerifyReport report;
  const body::BodyModel model = body::read_body(campaign.body_file);
  int64_t frames = 0;
  for (const Piece& piece : pieces) frames += piece.frames;
  Crew crew(options.threads, options.limits, campaign.garment_vertices);
  Progress progress("verify", frames, "frames");
  std::mutex mutex;
  std::set<std::string> machines;
  crew.run(static_cast<int>(pieces.size()), [&](int i) {
    const Piece& piece = pieces[i];
    const Chain& chain = manifest.chains[piece.chain];
    const Ingredients made_of = ingredients_of(campaign, manifest, options.folder, model, piece);
    const std::string where =
        Hdf5File::open(shard_path(options.folder, chain.key)).text_attribute("/", "machine");
    sim::Supervision supervision;
    supervision.should_stop = [&] { return crew.should_stop(); };
    supervision.on_frame = [&](const garment::Certificate&) {
      const std::lock_guard<std::mutex> lock(mutex);
      progress.advance(1);
    };
    const garment::Clip again =
        make_again(campaign, model, made_of, chain, piece.frames, supervision);
    if (again.poses.empty()) return;  // stopped
    const std::lock_guard<std::mutex> lock(mutex);
    ++report.pieces;
    report.frames += piece.frames;
    if (where != machine()) machines.insert(where);
    bool is_timed = false;
    for (int t = 0; t < piece.frames; ++t) {
      is_timed |= made_of.shard.certificates[t].reason == garment::kOutOfTime;
      if (is_same(again, made_of.shard, t)) continue;
      report.differences.push_back({piece, piece.first_frame + t, is_timed});
      break;
    }
  });
  report.machines.assign(machines.begin(), machines.end());
  report.is_interrupted = is_interrupted();
  return report;
}

FrameAgain run_frame_again(const Campaign& campaign, const Manifest& manifest,
                           const RunOptions& options, int chain, int frame) {
  const std::string path = shard_path(options.folder, manifest.chains[chain].key);
  if (std::filesystem::exists(path))
    for (const Piece& piece : pieces_of_chain(path, chain)) {
      const int t = frame - piece.first_frame;
      if (t < 0 || t >= piece.frames) continue;
      const body::BodyModel model = body::read_body(campaign.body_file);
      const Ingredients made_of = ingredients_of(campaign, manifest, options.folder, model, piece);
      Progress progress("rerun", t + 1, "frames");
      sim::Supervision supervision;
      supervision.max_seconds_per_drape = options.limits.max_seconds_per_drape;
      supervision.should_stop = is_interrupted;
      supervision.on_frame = [&](const garment::Certificate& c) { progress.advance(1, c.reason); };
      const garment::Clip again =
          make_again(campaign, model, made_of, manifest.chains[chain], t + 1, supervision);
      if (again.poses.empty()) return {};
      return {made_of.shard.certificates[t], again.certificates.back(),
              is_same(again, made_of.shard, t)};
    }
  throw InputError("chain " + manifest.chains[chain].key + " has no frame " +
                   std::to_string(frame) + ", or is not simulated yet");
}

Remade remake(const Campaign& campaign, const Manifest& manifest, const RunOptions& options,
              int chain, int frame) {
  const Chain& wanted = manifest.chains[chain];
  const MotionSource& source = campaign.motions[wanted.motion];
  const body::BodyModel model = body::read_body(campaign.body_file);
  body::Motion motion = body::load_motion(source.file, model, source.config);
  motion.name = source.name;
  if (frame < 0 || static_cast<size_t>(frame) >= motion.frames.size())
    throw InputError("chain " + wanted.key + " has no frame " + std::to_string(frame));
  motion.frames.resize(static_cast<size_t>(frame) + 1);
  Progress progress("remake", frame + 2, "drapes");
  Remade remade;
  remade.garment = sim::settle_garment(
      campaign.designs[wanted.design], garment::make_topology(campaign.garment_vertices), model,
      garment::middle_fabric(campaign.fabric), campaign.simulation, is_interrupted);
  progress.advance(1, "its garment");
  sim::Supervision supervision;
  supervision.max_seconds_per_drape = options.limits.max_seconds_per_drape;
  supervision.should_stop = is_interrupted;
  supervision.on_frame = [&](const garment::Certificate& c) { progress.advance(1, c.reason); };
  remade.clip = sim::simulate(remade.garment, model, campaign.shapes[wanted.shape], motion,
                              fabric_of(campaign, wanted), campaign.simulation, supervision);
  for (Points3& positions : remade.clip.positions)
    positions = positions.cast<float>().cast<double>();
  return remade;
}

}  // namespace pleat::campaign
