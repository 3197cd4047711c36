// The program as its user meets it: exit codes, messages, and what is left on disk.
#include <gmock/gmock.h>
#include <sys/wait.h>

#include <cstdio>
#include <limits>

#include "body/amass_file.h"
#include "body/body_file.h"
#include "tests/body/archive.h"
#include "tests/body/synthetic_body.h"
#include "tests/core/scratch.h"

namespace pleat::app {
namespace {

using testing::HasSubstr;

struct Outcome {
  int code = -1;
  std::string text;  // of stdout and stderr
};

Outcome pleat(const std::string& arguments) {
  Outcome outcome;
  std::FILE* pipe = ::popen(("'" PLEAT_PROGRAM "' " + arguments + " 2>&1 </dev/null").c_str(), "r");
  if (!pipe) return outcome;
  for (int c; (c = std::fgetc(pipe)) != EOF;) outcome.text += static_cast<char>(c);
  const int status = ::pclose(pipe);
  if (WIFEXITED(status)) outcome.code = WEXITSTATUS(status);
  return outcome;
}

// A folder with the box body, a motion and a study of the two.
struct Inputs {
  Scratch scratch;
  std::string body = scratch.path("body.npz"), motion = scratch.path("walk.npz");
  std::string more;  // of the study

  Inputs() {
    body::write_body(body, body::box_body());
    body::Motion walk{"walk", 30, std::vector<body::Pose>(6)};
    for (int k = 0; k < 6; ++k) walk.frames[k].rotations.row(16) << 0, 0, -0.4 - 0.05 * k;
    body::write_amass(motion, walk, Vec<3>::Zero());
  }

  std::string out() const { return scratch.path("out"); }
  std::string study() const {
    const std::string path = scratch.path("study.yaml");
    write_bytes(path, "output: " + out() + "\nbody: {file: " + body +
                          "}\nmotions: [{file: " + motion + "}]\ndesigns: [{name: tee}]\n" + more);
    return path;
  }

  // Exit code 2, one line that names every part, nothing written.
  void expect_refused(const std::string& arguments, const std::vector<std::string>& parts) const {
    const Outcome outcome = pleat(arguments);
    EXPECT_EQ(outcome.code, 2) << arguments << "\n" << outcome.text;
    EXPECT_EQ(std::count(outcome.text.begin(), outcome.text.end(), '\n'), 1) << outcome.text;
    for (const std::string& part : parts) EXPECT_THAT(outcome.text, HasSubstr(part));
    EXPECT_FALSE(std::filesystem::exists(out())) << arguments;
    for (const std::string& name : scratch.files())
      EXPECT_THAT(name, testing::Not(HasSubstr("tmp"))) << arguments;
  }
  void expect_study_refused(const std::vector<std::string>& parts) const {
    const std::string path = study();
    for (const std::string command : {"run ", "dress ", "simulate ", "encode "})
      expect_refused(command + path, parts);
  }
};

TEST(PleatProgram, TellsItsVersion) {
  const Outcome outcome = pleat("--version");
  EXPECT_EQ(outcome.code, 0);
  EXPECT_THAT(outcome.text, testing::MatchesRegex("pleat [0-9]+\\.[0-9]+\\.[0-9]+ \\(.+\\)\n"));
}

TEST(PleatProgram, HelpsWithEveryCommand) {
  const std::string all = pleat("--help").text;
  for (const std::string command :
       {"", "run", "dress", "simulate", "encode", "train", "sample", "evaluate", "body",
        "body anny", "body info", "motion", "motion info", "motion convert", "plan", "status",
        "check", "verify", "rerun", "index"}) {
    const Outcome outcome = pleat(command + " --help");
    EXPECT_EQ(outcome.code, 0) << command;
    EXPECT_THAT(outcome.text, HasSubstr("--help")) << command;
    EXPECT_THAT(all, HasSubstr(command.substr(0, command.find(' '))));
  }
}

TEST(PleatProgram, RefusesWrongArguments) {
  for (const std::string arguments :
       {"", "fly", "run", "body", "body fly", "motion info", "run a.yaml b.yaml", "run --fast x"}) {
    const Outcome outcome = pleat(arguments);
    EXPECT_EQ(outcome.code, 2) << arguments << "\n" << outcome.text;
    EXPECT_NE(outcome.text, "") << arguments;
  }
}

TEST(PleatProgram, RefusesAWrongStudy) {
  Inputs inputs;
  inputs.expect_refused("run " + inputs.scratch.path("absent.yaml"), {"absent.yaml"});
  inputs.more = "seed: 2\nsimulaton: {ease_deg: 6}\n";
  inputs.expect_study_refused({"study.yaml:6", "simulaton", "`simulation`"});
  inputs.more = "simulation: {ease_deg: -6}\n";
  inputs.expect_study_refused({"study.yaml:5", "simulation.ease_deg"});
  inputs.more = "shapes:\n  random: {count: 0, betas: 2}\n";
  inputs.expect_study_refused({"study.yaml:6: shapes.random.count = 0", "1 .. 100000"});
  inputs.more = "output: elsewhere\n";
  inputs.expect_study_refused({"study.yaml:5", "output", "twice"});
  inputs.more = "shapes: [[], [0, 0, 0, 1]]\n";  // the box has three directions
  inputs.expect_study_refused({"shape", "4", "3"});
}

TEST(PleatProgram, RefusesAMissingOrForeignBody) {
  Inputs inputs;
  const std::string good = inputs.body;
  inputs.body = inputs.scratch.path("absent.npz");
  inputs.expect_study_refused({"absent.npz"});
  inputs.expect_refused("body info " + inputs.body, {"absent.npz"});

  inputs.body = inputs.scratch.path("model.pkl");
  write_bytes(inputs.body, "\x80\x02}q\x01.");
  inputs.expect_study_refused({"model.pkl", "pickle", "np.savez"});
  inputs.expect_refused("body info " + inputs.body, {"model.pkl", "pickle"});

  inputs.body = inputs.scratch.path("holed.npz");
  std::vector<NpzEntry> entries = body::entries_of(good);
  NpyArray& faces = body::array_of(entries, "f");
  faces.shape[0] -= 1;
  faces.values.resize(faces.values.size() - 3);
  write_npz(inputs.body, entries);
  inputs.expect_study_refused({"holed.npz: f", "closed"});
  inputs.expect_refused("body info " + inputs.body, {"holed.npz: f"});

  inputs.body = inputs.scratch.path("nan.npz");
  entries = body::entries_of(good);
  body::array_of(entries, "v_template").values[10] = std::numeric_limits<double>::quiet_NaN();
  write_npz(inputs.body, entries);
  inputs.expect_study_refused({"nan.npz: v_template", "not finite"});

  inputs.body = inputs.motion;
  inputs.expect_study_refused({"walk.npz", "v_template"});
}

TEST(PleatProgram, RefusesAMissingOrDamagedMotion) {
  Inputs inputs;
  const std::string good = inputs.motion, bytes = read_bytes(good);
  const auto expect_refused = [&](const std::vector<std::string>& parts) {
    inputs.expect_study_refused(parts);
    inputs.expect_refused("motion info " + inputs.motion + " --body " + inputs.body, parts);
    inputs.expect_refused(
        "motion convert " + inputs.motion + " " + inputs.out() + " --body " + inputs.body, parts);
  };
  inputs.motion = inputs.scratch.path("absent.npz");
  expect_refused({"absent.npz"});

  inputs.motion = inputs.scratch.path("cut.npz");
  for (const size_t size : {size_t{0}, size_t{100}, bytes.size() / 2, bytes.size() - 10}) {
    write_bytes(inputs.motion, bytes.substr(0, size));
    expect_refused({"cut.npz"});
  }

  inputs.motion = inputs.scratch.path("nan.npz");
  std::vector<NpzEntry> entries = body::entries_of(good);
  body::array_of(entries, "poses").values[2 * 156 + 5] = std::numeric_limits<double>::quiet_NaN();
  write_npz(inputs.motion, entries);
  expect_refused({"nan.npz: poses", "not finite in frame 2"});

  inputs.motion = inputs.scratch.path("still.npz");
  entries = body::entries_of(good);
  body::remove_entry(entries, "mocap_framerate");
  write_npz(inputs.motion, entries);
  expect_refused({"still.npz", "mocap_framerate"});

  inputs.motion = inputs.scratch.path("cut.bvh");
  write_bytes(inputs.motion, "HIERARCHY\nROOT Hips\n{\n  OFFSET 0 0");
  expect_refused({"cut.bvh"});

  inputs.motion = inputs.scratch.path("walk.c3d");
  write_bytes(inputs.motion, "walk");
  expect_refused({"walk.c3d", "AMASS"});
}

TEST(PleatProgram, RefusesAMotionThatJumpsAndACutBeyondItsEnd) {
  Inputs inputs;
  inputs.more = "motion: {max_joint_step_deg: 1}\n";  // it turns by 2.9 degrees a frame
  inputs.expect_study_refused({"walk.npz", "left_shoulder"});
  inputs.more = "";
  inputs.motion += ", start_s: 9";
  inputs.expect_study_refused({"walk.npz", "start_s = 9"});
  inputs.motion += ", duration_s: .nan";
  inputs.expect_study_refused({"duration_s"});
}

TEST(PleatProgram, TellsOfBodiesAndMotions) {
  const Inputs inputs;
  const Outcome body = pleat("body info " + inputs.body);
  EXPECT_EQ(body.code, 0) << body.text;
  EXPECT_THAT(body.text, HasSubstr("joints            24"));
  const Outcome motion = pleat("motion info " + inputs.motion + " --body " + inputs.body);
  EXPECT_EQ(motion.code, 0) << motion.text;
  EXPECT_THAT(motion.text, HasSubstr("6 at 30.000 Hz"));
  const std::string copy = inputs.scratch.path("copy.npz");
  const Outcome convert =
      pleat("motion convert " + inputs.motion + " " + copy + " --body " + inputs.body);
  EXPECT_EQ(convert.code, 0) << convert.text;
  EXPECT_EQ(NpzFile(copy).shape("poses"), (std::vector<int64_t>{6, 156}));
}

}  // namespace
}  // namespace pleat::app
