// CGAL as an independent judge of what crosses: every pair of faces, exactly.
#pragma once

#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Triangle_3.h>
#include <CGAL/intersections.h>

#include <vector>

#include "core/types.h"

namespace pleat::judge {

using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using Triangle = CGAL::Triangle_3<Kernel>;

inline std::vector<Triangle> triangles(const Points3& x, const Faces& faces) {
  std::vector<Triangle> result;
  const auto point = [&](int v) { return Kernel::Point_3(x(v, 0), x(v, 1), x(v, 2)); };
  for (Eigen::Index f = 0; f < faces.rows(); ++f)
    result.emplace_back(point(faces(f, 0)), point(faces(f, 1)), point(faces(f, 2)));
  return result;
}

inline bool meet(const Triangle& s, const Triangle& t) {
  return CGAL::do_overlap(s.bbox(), t.bbox()) && CGAL::do_intersect(s, t);
}

// Pairs of a face of one and a face of the other that cross or touch.
inline int crossings(const Points3& x, const Faces& cloth, const Points3& body,
                     const Faces& body_faces) {
  const std::vector<Triangle> own = triangles(x, cloth), other = triangles(body, body_faces);
  int count = 0;
  for (const Triangle& s : own)
    for (const Triangle& t : other) count += meet(s, t);
  return count;
}

// Pairs within one mesh, those that share a vertex left out.
inline int self_crossings(const Points3& x, const Faces& faces) {
  const std::vector<Triangle> own = triangles(x, faces);
  const auto share_a_vertex = [&](Eigen::Index f, Eigen::Index g) {
    for (int a : {0, 1, 2})
      for (int b : {0, 1, 2})
        if (faces(f, a) == faces(g, b)) return true;
    return false;
  };
  int count = 0;
  for (Eigen::Index f = 0; f < faces.rows(); ++f)
    for (Eigen::Index g = 0; g < f; ++g) count += meet(own[f], own[g]) && !share_a_vertex(f, g);
  return count;
}

}  // namespace pleat::judge
