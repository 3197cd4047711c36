#include "body/bvh_file.h"

#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <functional>
#include <map>
#include <sstream>

#include "body/rotation.h"
#include "body/skinning.h"
#include "tests/body/synthetic_body.h"
#include "tests/core/input_error.h"
#include "tests/core/scratch.h"

namespace pleat::body {
namespace {

struct Node {
  std::string name;
  Vec<3> offset;  // cm
  std::vector<Node> children;
};

// Joint names of one family, in SMPL's order of collar, upper arm, forearm, hand; hip, knee, ankle,
// toe; spine.
struct Family {
  std::string collar, arm, forearm, hand, hip, knee, ankle, toe;
  std::vector<std::string> spine;
};
const Family kMotionBuilder = {"Shoulder", "Arm",     "ForeArm",
                               "Hand",     "UpLeg",   "Leg",
                               "Foot",     "ToeBase", {"LowerBack", "Spine", "Spine1"}};
const Family kMax = {"Collar", "Shoulder",         "Elbow", "Wrist", "Hip", "Knee", "Ankle",
                     "Toe",    {"Chest", "Chest2"}};

// A figure of 80 cm legs in a T-pose, or with its arms down.
Node skeleton(const Family& names, bool arms_down) {
  const auto limb = [&](const std::string& side, double x) {
    return Node{side + names.hip,
                {10 * x, -5, 0},
                {{side + names.knee,
                  {0, -40, 0},
                  {{side + names.ankle, {0, -40, 0}, {{side + names.toe, {0, -5, 12}, {}}}}}}}};
  };
  const auto arm = [&](const std::string& side, double x) {
    const Vec<3> along = arms_down ? Vec<3>(0, -1, 0) : Vec<3>(x, 0, 0);
    return Node{side + names.collar,
                {5 * x, 12, 0},
                {{side + names.arm,
                  {12 * x, 0, 0},
                  {{side + names.forearm, 26 * along, {{side + names.hand, 24 * along, {}}}}}}}};
  };
  Node top{names.spine.back(),
           {0, 12, 0},
           {arm("Left", 1), arm("Right", -1), {"Neck", {0, 20, 0}, {{"Head", {0, 10, 0}, {}}}}}};
  for (size_t k = names.spine.size() - 1; k-- > 0;) top = {names.spine[k], {0, 12, 0}, {top}};
  return {"Hips", {0, 0, 0}, {limb("Left", 1), limb("Right", -1), top}};
}

using Angles = std::map<std::string, Vec<3>>;  // joint -> Z, Y, X rotation, degrees

std::string bvh_text(const Node& root, const std::vector<std::pair<Vec<3>, Angles>>& frames,
                     double frame_time, const Mat<3>& axes = Mat<3>::Identity()) {
  std::ostringstream text;
  std::vector<std::string> order;
  const std::function<void(const Node&, bool)> write = [&](const Node& node, bool is_root) {
    order.push_back(node.name);
    const Vec<3> offset = axes * node.offset;
    text << (is_root ? "ROOT " : "JOINT ") << node.name << "\n{\nOFFSET " << offset.transpose()
         << "\nCHANNELS " << (is_root ? "6 Xposition Yposition Zposition" : "3")
         << " Zrotation Yrotation Xrotation\n";
    for (const Node& child : node.children) write(child, false);
    if (node.children.empty()) text << "End Site\n{\nOFFSET 0 1 0\n}\n";
    text << "}\n";
  };
  text << "HIERARCHY\n";
  write(root, true);
  text << "MOTION\nFrames: " << frames.size() << "\nFrame Time: " << frame_time << "\n";
  for (const auto& [position, angles] : frames) {
    text << position.transpose();
    for (const std::string& name : order) {
      const auto it = angles.find(name);
      text << ' ' << (it == angles.end() ? Vec<3>(0, 0, 0) : it->second).transpose();
    }
    text << '\n';
  }
  return text.str();
}

// Joint positions of the mean body in a pose.
Points3 posed_joints(const BodyModel& model, const Pose& pose) {
  const ShapedBody body = shape_body(model, Eigen::VectorXd());
  const std::vector<Transform> transforms = joint_transforms(model, body, pose);
  Points3 joints(kJoints, 3);
  for (int j = 0; j < kJoints; ++j) {
    joints.row(j) =
        (transforms[j].leftCols<3>() * body.joints.row(j).transpose() + transforms[j].col(3))
            .transpose();
  }
  return joints;
}

void expect_bone(const Points3& joints, int from, int to, const Vec<3>& direction,
                 double tolerance = 1e-5) {
  const Vec<3> bone = (joints.row(to) - joints.row(from)).normalized();
  EXPECT_LT((bone - direction.normalized()).norm(), tolerance)
      << kJointNames[from] << " to " << kJointNames[to] << ": " << bone.transpose();
}

class BvhFile : public testing::Test {
 protected:
  std::string write(const std::string& text) {
    write_bytes(scratch_.path("figure.bvh"), text);
    return scratch_.path("figure.bvh");
  }
  Scratch scratch_;
  BodyModel model_ = box_body();
};

TEST_F(BvhFile, BonesPointWhereTheFileHasThem) {
  for (const bool is_max : {false, true}) {
    const Family& names = is_max ? kMax : kMotionBuilder;
    Angles angles;  // left arm down, right forearm forwards, left knee bent back
    if (is_max) {   // the zero pose has arms down
      angles["Right" + names.arm] = {-90, 0, 0};
    } else {
      angles["Left" + names.arm] = {-90, 0, 0};
    }
    angles["Right" + names.forearm] = is_max ? Vec<3>(0, 0, -90) : Vec<3>(0, 90, 0);
    angles["Left" + names.knee] = {0, 0, 90};
    const Motion motion =
        read_bvh(write(bvh_text(skeleton(names, is_max), {{{0, 90, 0}, angles}}, 0.01)), model_);
    ASSERT_EQ(motion.frames.size(), 1u);
    EXPECT_EQ(motion.frame_rate_hz, 100);
    const Points3 joints = posed_joints(model_, motion.frames[0]);
    expect_bone(joints, 16, 18, {0, -1, 0});
    expect_bone(joints, 17, 19, {-1, 0, 0});
    expect_bone(joints, 19, 21, {0, 0, 1});
    expect_bone(joints, 1, 4, {0, -1, 0});
    expect_bone(joints, 4, 7, {0, 0, -1});
    expect_bone(joints, 2, 5, {0, -1, 0});
    EXPECT_TRUE(motion.frames[0].rotations.bottomRows(2).isZero(1e-12));
  }
}

TEST_F(BvhFile, RootFollowsTheHipsAtTheBodysScale) {
  const Points3 rest = human_joints();
  const double leg = (rest.row(4) - rest.row(1)).norm() + (rest.row(7) - rest.row(4)).norm();
  const double scale = leg / 80;  // m per file unit
  Angles angles = {{"Hips", {0, 90, 0}}};
  const Motion motion =
      read_bvh(write(bvh_text(skeleton(kMotionBuilder, false),
                              {{{100, 90, 20}, {}}, {{100, 90, 50}, angles}}, 1 / 30.0)),
               model_);
  EXPECT_EQ(motion.frame_rate_hz, 30);
  for (int k = 0; k < 2; ++k) {
    const Points3 joints = posed_joints(model_, motion.frames[k]);
    const Vec<3> hips = (joints.row(1) + joints.row(2)) / 2;
    EXPECT_LT((hips - scale * Vec<3>(100, 85, k == 0 ? 20 : 50)).norm(), 1e-5);
    // Facing +z, then turned to +x.
    const Vec<3> facing = rotation_matrix(motion.frames[k].rotations.row(0)).col(2);
    EXPECT_LT((facing - (k == 0 ? Vec<3>(0, 0, 1) : Vec<3>(1, 0, 0))).norm(), 1e-6);
  }
}

TEST_F(BvhFile, CollarsSinkWithTheArms) {
  const std::string path =
      write(bvh_text(skeleton(kMotionBuilder, false),
                     {{{0, 90, 0}, {}}, {{0, 90, 0}, {{"LeftArm", {-90, 0, 0}}}}}, 1 / 30.0));
  const Motion motion = read_bvh(path, model_);
  EXPECT_LT(motion.frames[0].rotations.row(13).norm(), 1e-9);
  EXPECT_NEAR(motion.frames[1].rotations(13, 2), -8 * M_PI / 180, 1e-6);
  EXPECT_LT(motion.frames[1].rotations.row(14).norm(), 1e-9);
}

TEST_F(BvhFile, AbductionTakesHangingArmsOutwards) {
  const std::string path = write(
      bvh_text(skeleton(kMotionBuilder, false),
               {{{0, 90, 0}, {{"LeftArm", {-90, 0, 0}}, {"RightArm", {90, 0, 0}}}}}, 1 / 30.0));
  const Points3 joints = posed_joints(model_, read_bvh(path, model_, 10).frames[0]);
  const double sine = std::sin(10 * M_PI / 180), cosine = std::cos(10 * M_PI / 180);
  expect_bone(joints, 16, 18, {sine, -cosine, 0});
  expect_bone(joints, 17, 19, {-sine, -cosine, 0});
}

TEST_F(BvhFile, TurnsAZUpFileUpright) {
  Mat<3> z_up;  // y up, +z front -> z up, -y front
  z_up << 1, 0, 0, 0, 0, -1, 0, 1, 0;
  const Motion motion = read_bvh(
      write(bvh_text(skeleton(kMotionBuilder, false), {{{0, 0, 90}, {}}}, 1 / 30.0, z_up)), model_);
  const Points3 joints = posed_joints(model_, motion.frames[0]);
  EXPECT_GT(joints(15, 1), joints(0, 1) + 0.4);
  EXPECT_GT(joints(16, 0), 0.1);
  EXPECT_GT(joints(10, 2), joints(7, 2));
}

TEST_F(BvhFile, RefusesWhatIsNoFigureOrNotFinite) {
  const Node figure = skeleton(kMotionBuilder, false);
  EXPECT_INPUT_ERROR(read_bvh(scratch_.path("none.bvh"), model_), "none.bvh");
  EXPECT_INPUT_ERROR(read_bvh(write("HIERARCHY\nROOT"), model_), "figure.bvh");
  EXPECT_INPUT_ERROR(read_bvh(write("v 0 0 0\n"), model_), "figure.bvh");
  Node legless = figure;
  legless.children.erase(legless.children.begin());
  EXPECT_INPUT_ERROR(read_bvh(write(bvh_text(legless, {{{0, 0, 0}, {}}}, 0.1)), model_),
                     "figure.bvh", "left_hip", "LeftUpLeg");
  std::string text =
      bvh_text(figure, {{{0, 90, 0}, {}}, {{0, 90, 0}, {{"LeftArm", {-77, 0, 0}}}}}, 0.1);
  text.replace(text.rfind("-77"), 3, "nan");
  EXPECT_INPUT_ERROR(read_bvh(write(text), model_), "figure.bvh", "LeftArm", "frame 1");
  text = bvh_text(figure, {{{0, 90, 0}, {}}, {{0, 90, 0}, {}}}, 0.1);
  EXPECT_INPUT_ERROR(read_bvh(write(text.substr(0, text.size() - 20)), model_), "figure.bvh");
}

// Debian's assimp-testmodels: CMU 01_01, a T-pose and then a forward jump again and again.
TEST(CmuMotion, JumpsAndStandsUpright) {
  const std::string path = "/usr/share/assimp/models/BVH/01_01.bvh";
  if (!std::filesystem::exists(path))
    GTEST_SKIP() << path << " is absent (package assimp-testmodels)";
  const BodyModel model = box_body();
  const MotionInfo info = motion_info(path, model, {});
  EXPECT_EQ(info.frames, 2752);
  EXPECT_EQ(info.frame_rate_hz, 120);
  EXPECT_EQ(info.t_poses_dropped, 1);
  EXPECT_EQ(info.problem, "");
  const Motion motion = load_motion(path, model, {});
  ASSERT_EQ(motion.frames.size(), 688u);
  const auto joints_at = [&](double s) {
    return posed_joints(model, motion.frames[static_cast<size_t>(s * 30)]);
  };
  const Points3 standing = joints_at(1), flying = joints_at(6.75);
  EXPECT_GT(standing(15, 1), standing(0, 1) + 0.4);    // head above pelvis
  EXPECT_GT(standing(0, 1), standing(7, 1) + 0.6);     // pelvis above ankle
  EXPECT_GT(standing(10, 2), standing(7, 2) + 0.05);   // toes to +z
  EXPECT_LT(standing(18, 1), standing(16, 1) - 0.15);  // elbow below shoulder
  EXPECT_GT(flying(7, 1), standing(7, 1) + 0.1);
  EXPECT_GT(flying(8, 1), standing(8, 1) + 0.1);
}

TEST(CmuMotion, AllOfACollectionLoadsOrIsRefusedByName) {
  const char* folder = std::getenv("PLEAT_CMU_DIR");
  if (!folder) GTEST_SKIP() << "PLEAT_CMU_DIR is not set";
  const BodyModel model = box_body();
  int loaded = 0;
  for (const auto& entry : std::filesystem::directory_iterator(folder)) {
    if (entry.path().extension() != ".bvh") continue;
    const std::string path = entry.path().string();
    SCOPED_TRACE(path);
    if (path.find("GLITCHY") != std::string::npos) {
      EXPECT_INPUT_ERROR(load_motion(path, model, {}), path, "frame");
      continue;
    }
    const Motion motion = load_motion(path, model, {});
    int upright = 0;
    for (const Pose& pose : motion.frames) {
      const Points3 joints = posed_joints(model, pose);
      upright += joints(15, 1) > joints(0, 1) + 0.2;
    }
    EXPECT_GT(upright, 0.6 * static_cast<double>(motion.frames.size()));
    ++loaded;
  }
  EXPECT_GT(loaded, 0);
}

}  // namespace
}  // namespace pleat::body
