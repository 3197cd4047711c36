// Dressing without hands: every panel is laid on a tube around the torso or an arm, the tubes are
// joined along the seams, and the cloth is let slip over the body until its edges have about their
// rest lengths.
#include <Eigen/Geometry>
#include <Eigen/SparseCholesky>
#include <algorithm>
#include <cmath>
#include <map>

#include "body/skinning.h"
#include "core/mesh.h"
#include "core/mesh_quality.h"
#include "core/proximity.h"
#include "garment/template.h"

namespace pleat::garment {
namespace {

constexpr double kTubeClearance = 0.020;  // m, of the first tubes to the body
constexpr double kClearance = 0.014;      // m, that the slipping cloth keeps from the body
constexpr double kSmallestGap = 0.009;    // m, that every vertex has in the end
constexpr int kSlips = 20;
// Edges beyond these are let slip. Those in between are left: pushed apart to their rest lengths,
// they would buckle.
constexpr double kLeastStretch = 0.75, kMostStretch = 1.15;
constexpr double kInertia = 0.10;  // of a vertex against the springs of its edges
constexpr double kPi = 3.14159265358979323846;

// Joints of SMPL.
enum Joint {
  kNeck = 12,
  kHead = 15,
  kLeftShoulder = 16,
  kLeftElbow = 18,
  kLeftWrist = 20,
  kRightWrist = 21
};

// A quantity along one coordinate: linear between its samples, constant beyond them.
struct Profile {
  std::map<double, double> samples;
  double at(double t) const {
    const auto above = samples.lower_bound(t);
    if (above == samples.end()) return samples.rbegin()->second;
    if (above == samples.begin()) return above->second;
    const auto below = std::prev(above);
    const double s = (t - below->first) / (above->first - below->first);
    return (1 - s) * below->second + s * above->second;
  }
};

struct Wearer {
  Points3 vertices, joints;  // T-pose
  std::vector<char> is_arm, is_head;
};

Wearer wearer_in_t_pose(const body::BodyModel& model, const body::ShapedBody& body) {
  Wearer wearer{body::pose_body(model, body, body::Pose{}), body.joints, {}, {}};
  for (int v = 0; v < wearer.vertices.rows(); ++v) {
    double arm = 0, head = 0;
    for (SkinWeights::InnerIterator w(model.weights, v); w; ++w) {
      int joint = static_cast<int>(w.col());
      while (joint > kRightWrist + 2) joint = model.parents[joint];  // fingers and face
      if (joint >= kLeftShoulder) arm += w.value();
      if (joint == kNeck || joint == kHead) head += w.value();
    }
    wearer.is_arm.push_back(arm > 0.5);
    wearer.is_head.push_back(head > 0.5);
  }
  return wearer;
}

// What the tubes need to know of the panels.
struct Cut {
  double underarm_y = 0, armhole_top_x = 0, armhole_top_y = 0;  // of the front
  double neck_x = 0, neck_y = 0;                                // shoulder-neck point of the front
  double cap_y = 0, sleeve_hem_y = 0;                           // highest and lowest of the sleeve
  Profile torso_half_width, sleeve_half_width;                  // along the side seams, by panel y
};

Cut measure(const GarmentTopology& topology, const Points2& panels) {
  // How often each panel uses a sewn vertex tells the seams apart.
  std::vector<std::array<int, 4>> uses(static_cast<size_t>(topology.vertex_count), {0, 0, 0, 0});
  for (Eigen::Index v = 0; v < panels.rows(); ++v)
    ++uses[topology.sewn_vertex[v]][static_cast<size_t>(topology.panel_of_vertex[v])];
  Cut cut;
  cut.cap_y = cut.armhole_top_y = cut.neck_y = -1e9;
  const auto each = [&](Panel panel, const auto& look) {
    for (Eigen::Index v = 0; v < panels.rows(); ++v)
      if (topology.panel_of_vertex[v] == panel && panels(v, 0) >= 0)
        look(uses[topology.sewn_vertex[v]], panels(v, 0), panels(v, 1));
  };
  const auto sleeve_uses = [](const std::array<int, 4>& use) { return use[2] + use[3]; };
  each(Panel::kFront, [&](const std::array<int, 4>& use, double x, double y) {
    if (sleeve_uses(use) == 2) cut.underarm_y = y;
    if (sleeve_uses(use) == 1 && y > cut.armhole_top_y) {
      cut.armhole_top_x = x;
      cut.armhole_top_y = y;
    }
    if (use[1] && y > cut.neck_y) {
      cut.neck_x = x;
      cut.neck_y = y;
    }
  });
  each(Panel::kFront, [&](const std::array<int, 4>& use, double x, double y) {
    if (use[1] && y <= cut.underarm_y) cut.torso_half_width.samples[y] = x;
  });
  each(Panel::kLeftSleeve, [&](const std::array<int, 4>& use, double x, double y) {
    cut.cap_y = std::max(cut.cap_y, y);
    cut.sleeve_hem_y = std::min(cut.sleeve_hem_y, y);
    if (use[2] == 2) cut.sleeve_half_width.samples[y] = x;
  });
  return cut;
}

double ellipse_perimeter(double a, double b) {  // Ramanujan 1914
  return kPi * (3 * (a + b) - std::sqrt((3 * a + b) * (a + 3 * b)));
}

// The tubes: around the torso about the vertical, around the arms along them.
class Tubes {
 public:
  Tubes(const Wearer& wearer, const Cut& cut) : cut_(cut) {
    center_x_ = wearer.joints(0, 0);
    measure_shoulder(wearer);
    measure_torso(wearer);
    for (const int side : {1, -1}) measure_arm(wearer, side);
  }

  Vec<3> place(Panel panel, const Vec<2>& p) const {
    return is_sleeve(panel) ? place_sleeve(panel, p) : place_torso(panel, p);
  }

 private:
  struct Arm {
    Profile y, z, radius;  // by distance from the middle of the body
    double wrist = 0;      // there
  };

  void measure_shoulder(const Wearer& wearer) {
    shoulder_y_ = -1e9;
    double weight = 0, z = 0;
    for (Eigen::Index v = 0; v < wearer.vertices.rows(); ++v) {
      if (wearer.is_head[v]) continue;
      if (std::abs(std::abs(wearer.vertices(v, 0) - center_x_) - cut_.armhole_top_x) > 0.02)
        continue;
      shoulder_y_ = std::max(shoulder_y_, wearer.vertices(v, 1));
    }
    for (Eigen::Index v = 0; v < wearer.vertices.rows(); ++v) {
      const double x = std::abs(wearer.vertices(v, 0) - center_x_);
      if (wearer.is_head[v] || x > cut_.armhole_top_x || wearer.vertices(v, 1) < shoulder_y_ - 0.01)
        continue;
      z += wearer.vertices(v, 2);
      weight += 1;
    }
    shoulder_z_ = z / std::max(weight, 1.0);
    level_ = shoulder_y_ + kTubeClearance - cut_.armhole_top_y;  // world height of panel y = 0
  }

  // Half extents of the torso and legs at each height, the largest within 3 cm.
  void measure_torso(const Wearer& wearer) {
    constexpr double kStep = 0.02, kWindow = 0.03;
    const double low = wearer.vertices.col(1).minCoeff();
    for (double y = low; y < shoulder_y_; y += kStep) {
      double x = 0, front = -1e9, back = 1e9;
      for (Eigen::Index v = 0; v < wearer.vertices.rows(); ++v) {
        if (wearer.is_arm[v] || wearer.is_head[v] || std::abs(wearer.vertices(v, 1) - y) > kWindow)
          continue;
        x = std::max(x, std::abs(wearer.vertices(v, 0) - center_x_));
        front = std::max(front, wearer.vertices(v, 2));
        back = std::min(back, wearer.vertices(v, 2));
      }
      if (front < back) continue;
      torso_x_.samples[y] = x;
      torso_z_.samples[y] = 0.5 * (front + back);
      torso_depth_.samples[y] = 0.5 * (front - back);
    }
  }

  void measure_arm(const Wearer& wearer, int side) {
    constexpr double kStep = 0.02, kWindow = 0.025;
    Arm& arm = side > 0 ? left_arm_ : right_arm_;
    for (const int joint : {kLeftShoulder, kLeftElbow, kLeftWrist}) {
      const Eigen::Index j = joint + (side > 0 ? 0 : 1);
      const double along = side * (wearer.joints(j, 0) - center_x_);
      arm.y.samples[along] = wearer.joints(j, 1);
      arm.z.samples[along] = wearer.joints(j, 2);
    }
    const double shoulder = arm.y.samples.begin()->first;
    arm.wrist = arm.y.samples.rbegin()->first;
    for (double x = shoulder + 0.04; x < arm.wrist; x += kStep) {
      double radius = 0;
      for (Eigen::Index v = 0; v < wearer.vertices.rows(); ++v) {
        const double along = side * (wearer.vertices(v, 0) - center_x_);
        if (!wearer.is_arm[v] || std::abs(along - x) > kWindow) continue;
        radius = std::max(radius, std::hypot(wearer.vertices(v, 1) - arm.y.at(along),
                                             wearer.vertices(v, 2) - arm.z.at(along)));
      }
      arm.radius.samples[x] = radius;
    }
  }

  Vec<3> place_torso(Panel panel, const Vec<2>& p) const {
    const double x = p.x() * left_side(panel);  // towards the wearer's left
    const double facing = panel == Panel::kFront ? 1 : -1;
    const double row = std::min(p.y(), cut_.underarm_y);
    const double half_width = cut_.torso_half_width.at(row);
    // An ellipse as long as the cloth, or longer where the body needs it.
    const double y = level_ + row;
    const double a0 = torso_x_.at(y), b0 = torso_depth_.at(y);
    const double ease =
        std::max(kTubeClearance, (4 * half_width - ellipse_perimeter(a0, b0)) / (2 * kPi));
    const double angle = 0.5 * kPi * x / half_width;
    Vec<3> point((a0 + ease) * std::sin(angle), level_ + p.y(),
                 torso_z_.at(y) + facing * (b0 + ease) * std::cos(angle));
    if (p.y() > cut_.underarm_y) {
      // A dome up to the shoulder seam, which is straight and runs on over the neck.
      const double slope = (cut_.armhole_top_y - cut_.neck_y) / (cut_.armhole_top_x - cut_.neck_x);
      const double seam_y = cut_.neck_y + slope * (std::abs(x) - cut_.neck_x);
      const double up =
          std::clamp((p.y() - cut_.underarm_y) / (seam_y - cut_.underarm_y), 0.0, 1.0);
      const double dome = std::sqrt(1 - up * up);
      const double chest_z = torso_z_.at(y);
      point.x() = (1 - up) * point.x() + up * x;
      point.z() = (1 - up) * chest_z + up * shoulder_z_ + dome * (point.z() - chest_z);
    }
    point.x() += center_x_;
    return point;
  }

  Vec<3> place_sleeve(Panel panel, const Vec<2>& p) const {
    const int side = panel == Panel::kLeftSleeve ? 1 : -1;
    const Arm& arm = side > 0 ? left_arm_ : right_arm_;
    // A sleeve that is too long for the arm is pushed up, so that it does not catch on the thumb.
    const double length = cut_.cap_y - cut_.sleeve_hem_y;
    const double push = std::min(1.0, (arm.wrist - cut_.armhole_top_x) / length);
    const double along = cut_.armhole_top_x + push * (cut_.cap_y - p.y());
    const double half_width = cut_.sleeve_half_width.at(p.y());
    const double radius = std::max(half_width / kPi, arm.radius.at(along) + kTubeClearance);
    const double angle = kPi * p.x() * front_side(panel) / half_width;  // from the top to the front
    return {center_x_ + side * along, arm.y.at(along) + radius * std::cos(angle),
            arm.z.at(along) + radius * std::sin(angle)};
  }

  Cut cut_;
  double center_x_ = 0, shoulder_y_ = 0, shoulder_z_ = 0, level_ = 0;
  Profile torso_x_, torso_z_, torso_depth_;
  Arm left_arm_, right_arm_;
};

// The cloth as springs along the edges of the sewn mesh.
struct Springs {
  std::vector<Edge> edges;
  Eigen::VectorXd rest_lengths;  // the mean of both sides on a seam
};

Springs make_springs(const GarmentTopology& topology, const Points2& panels) {
  std::map<std::array<int, 2>, std::array<double, 2>> lengths;  // edge -> sum, count
  for (Eigen::Index f = 0; f < topology.faces.rows(); ++f)
    for (int k = 0; k < 3; ++k) {
      const int a = topology.faces(f, k), b = topology.faces(f, (k + 1) % 3);
      std::array<double, 2>& entry = lengths[{std::min(a, b), std::max(a, b)}];
      entry[0] += (panels.row(topology.panel_faces(f, k)) -
                   panels.row(topology.panel_faces(f, (k + 1) % 3)))
                      .norm();
      entry[1] += 1;
    }
  Springs springs{edges(topology.faces), {}};
  springs.rest_lengths.resize(static_cast<Eigen::Index>(springs.edges.size()));
  for (size_t e = 0; e < springs.edges.size(); ++e) {
    const std::array<double, 2>& entry = lengths.at(springs.edges[e].vertices);
    springs.rest_lengths[static_cast<Eigen::Index>(e)] = entry[0] / entry[1];
  }
  return springs;
}

// Laplacian of the edges' graph plus `inertia` on the diagonal.
Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>> factor(const Springs& springs, int vertex_count,
                                                          double inertia) {
  std::vector<Eigen::Triplet<double>> entries;
  for (const Edge& edge : springs.edges) {
    const auto [a, b] = edge.vertices;
    entries.insert(entries.end(), {{a, a, 1.0}, {b, b, 1.0}, {a, b, -1.0}, {b, a, -1.0}});
  }
  for (int v = 0; v < vertex_count; ++v) entries.emplace_back(v, v, inertia);
  Eigen::SparseMatrix<double> matrix(vertex_count, vertex_count);
  matrix.setFromTriplets(entries.begin(), entries.end());
  return Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>>(matrix);
}

// Joins the tubes: edges as close as can be to what they are on each tube, in the least squares.
Points3 join_tubes(const GarmentTopology& topology, const Points3& on_tubes,
                   const Springs& springs) {
  // The joint reaches this far into the panels; beyond it they stay on their tubes.
  constexpr double kReach = 0.06;  // m
  const double anchor = std::pow(springs.rest_lengths.mean() / kReach, 2);
  const int count = topology.vertex_count;
  Points3 mean = Points3::Zero(count, 3);
  Eigen::VectorXd uses = Eigen::VectorXd::Zero(count);
  for (Eigen::Index v = 0; v < on_tubes.rows(); ++v) {
    mean.row(topology.sewn_vertex[v]) += on_tubes.row(v);
    uses[topology.sewn_vertex[v]] += 1;
  }
  mean.array().colwise() /= uses.array();
  std::map<std::array<int, 2>, double> faces_at;
  for (Eigen::Index f = 0; f < topology.faces.rows(); ++f)
    for (int k = 0; k < 3; ++k) {
      const int a = topology.faces(f, k), b = topology.faces(f, (k + 1) % 3);
      faces_at[{std::min(a, b), std::max(a, b)}] += 1;
    }
  Points3 right_side = anchor * mean;
  for (Eigen::Index f = 0; f < topology.faces.rows(); ++f)
    for (int k = 0; k < 3; ++k) {
      const int a = topology.faces(f, k), b = topology.faces(f, (k + 1) % 3);
      const Eigen::RowVector3d d = (on_tubes.row(topology.panel_faces(f, k)) -
                                    on_tubes.row(topology.panel_faces(f, (k + 1) % 3))) /
                                   faces_at[{std::min(a, b), std::max(a, b)}];
      right_side.row(a) += d;
      right_side.row(b) -= d;
    }
  return factor(springs, count, anchor).solve(right_side);
}

// Moves points nearer than `gap` to the body out to `gap`. Returns how many.
int push_out(const SurfaceTree& body, double gap, Points3& points) {
  constexpr double kReach = 0.25;  // m
  const Eigen::VectorXd distances = signed_distances(body, points, kReach);
  int count = 0;
  for (Eigen::Index v = 0; v < points.rows(); ++v) {
    if (distances[v] >= gap) continue;
    const Vec<3> p = points.row(v);
    const ClosestPoint closest = body.closest(p, kReach);
    if (closest.face < 0) continue;
    Vec<3> outward = p - closest.point;
    if (outward.norm() > 1e-4) {
      outward *= (distances[v] < 0 ? -1 : 1) / outward.norm();
    } else {
      const Points3& x = body.vertices();
      const Vec<3> a = x.row(body.faces()(closest.face, 0)),
                   b = x.row(body.faces()(closest.face, 1)),
                   c = x.row(body.faces()(closest.face, 2));
      outward = (b - a).cross(c - a).normalized();
    }
    points.row(v) = closest.point + gap * outward;
    ++count;
  }
  return count;
}

// Brings edges between kLeastStretch and kMostStretch, outside the body (local-global steps,
// Bouaziz et al. 2014).
void slip(const SurfaceTree& body, const Springs& springs, Points3& points) {
  const auto system = factor(springs, static_cast<int>(points.rows()), kInertia);
  for (int i = 0; i < kSlips; ++i) {
    push_out(body, kClearance, points);
    Points3 right_side = kInertia * points;
    for (size_t e = 0; e < springs.edges.size(); ++e) {
      const auto [a, b] = springs.edges[e].vertices;
      const Eigen::RowVector3d d = points.row(a) - points.row(b);
      const double length = d.norm(), rest = springs.rest_lengths[static_cast<Eigen::Index>(e)];
      const Eigen::RowVector3d goal =
          d * (std::clamp(length, kLeastStretch * rest, kMostStretch * rest) / length);
      right_side.row(a) += goal;
      right_side.row(b) -= goal;
    }
    points = system.solve(right_side);
  }
}

// Until no vertex is nearer than kSmallestGap and no face cuts into the body.
void clear_body(const SurfaceTree& body, const Faces& faces, Points3& points) {
  SurfaceTree cloth(points, faces);
  double gap = kSmallestGap + 0.001;
  for (int i = 0; i < 12; ++i) {
    while (push_out(body, gap, points) > 0 &&
           signed_distances(body, points, 0.1).minCoeff() < kSmallestGap) {
    }
    cloth.refit(points);
    if (intersecting_faces(cloth, body).empty()) return;
    gap += 0.003;
  }
}

}  // namespace

Points3 place_around_body(const GarmentTopology& topology, const Points2& panels,
                          const body::BodyModel& model, const body::ShapedBody& body) {
  const Wearer wearer = wearer_in_t_pose(model, body);
  const Tubes tubes(wearer, measure(topology, panels));
  Points3 on_tubes(panels.rows(), 3);
  for (Eigen::Index v = 0; v < panels.rows(); ++v)
    on_tubes.row(v) = tubes.place(topology.panel_of_vertex[v], panels.row(v));
  const Springs springs = make_springs(topology, panels);
  Points3 points = join_tubes(topology, on_tubes, springs);
  const SurfaceTree surface(wearer.vertices, model.faces);
  slip(surface, springs, points);
  clear_body(surface, topology.faces, points);
  return points;
}

}  // namespace pleat::garment
