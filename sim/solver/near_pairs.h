// Pairs of features, corner and face or edge and edge, of cloth and body that are near one another
// or will be on their way.
#pragma once

#include <vector>

#include "core/proximity.h"
#include "sim/body_contact.h"
#include "sim/solver/pair_distance.h"

namespace pleat::sim {

struct NearPair {
  std::array<int, 4> vertices;  // cloth 0 .. N-1, body N ..
  PairKind kind;
  double distance;  // m, at the start
};

// How near is looked for, m: the distance of two features, to which the reaches of their vertices
// are added.
struct PairRanges {
  double cloth_m;  // cloth and cloth
  double body_m;   // cloth and body
  double rest_m;   // cloth corners and body faces: what the smooth surface may support; >= body_m
};

// Of cloth and body together: row v < N is cloth, row N + b the body.
struct Scene {
  Points3 positions;      // m
  Points3 motion;         // m, from `positions`; empty: all stay
  Eigen::VectorXd reach;  // m, how far each vertex may stray from its way
  // What cloth and body do not hold off each other: body faces that are switched off, with the
  // edges and corners that only such faces share, and loose cloth vertices. Empty: none.
  std::vector<char> is_face_off, is_loose;
  // Cloth vertices: pairs without any of these are left out. Empty: none.
  std::vector<char> is_asked;
};

struct Plate;  // a face of the scene as the finder looks at it

class PairFinder {
 public:
  PairFinder(const Faces& cloth, const Eigen::Ref<const Points3>& cloth_positions,
             const Faces& body, const Eigen::Ref<const Points3>& body_positions);
  ~PairFinder();

  struct Found {
    std::vector<NearPair> pairs;
    // Body faces that cloth vertex v, asked for, may rest on: rest_faces[rest_start[v]] ..
    // [rest_start[v + 1]].
    std::vector<int> rest_start, rest_faces;
  };
  // All pairs that come into range. On the way (with motion) `distance` is that at the start, and
  // nothing is said of rest.
  Found find(const Scene& scene, const PairRanges& ranges);

 private:
  struct Part {  // cloth or body
    Faces faces;
    int first;                // vertex of the scene
    std::vector<char> owned;  // of each face: bits 0-2 corners, 3-5 edges from corner k to the next
    Faces across;             // of each face: the face behind each of these edges, -1 at a boundary
    SweptTree tree;
  };
  void refit_body(const Scene& scene, double range);

  Part cloth_, body_;
  // The body as it was last, which mostly stands still: rows of the scene, and how far around them
  // was looked.
  Points3 body_positions_, body_motion_;
  Eigen::VectorXd body_reach_;
  std::vector<Plate> body_plates_;
};

}  // namespace pleat::sim
