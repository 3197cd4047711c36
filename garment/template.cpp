#include "garment/template.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "core/error.h"
#include "garment/design_map.h"
#include "garment/panel_layout.h"
#include "garment/panel_mesh.h"

namespace pleat::garment {
namespace {

// The panels, each meshed once: the right sleeve is the left one's mirror image, vertex by vertex.
struct PanelMeshes {
  PanelMesh front, back, left_sleeve, right_sleeve;
  const PanelMesh& of(Panel panel) const {
    switch (panel) {
      case Panel::kFront:
        return front;
      case Panel::kBack:
        return back;
      case Panel::kLeftSleeve:
        return left_sleeve;
      default:
        return right_sleeve;
    }
  }
};

PanelMesh mirrored(PanelMesh mesh) {
  mesh.points.col(0) *= -1;
  mesh.faces.col(1).swap(mesh.faces.col(2));
  for (std::array<std::vector<int>, 2>& curve : mesh.curves) std::swap(curve[0], curve[1]);
  return mesh;
}

PanelMeshes mesh_panels(double spacing) {
  const Design reference = reference_design();
  PanelMeshes meshes;
  meshes.front = mesh_panel(half_outline(Panel::kFront, reference), spacing);
  meshes.back = mesh_panel(half_outline(Panel::kBack, reference), spacing);
  meshes.left_sleeve = mesh_panel(half_outline(Panel::kLeftSleeve, reference), spacing);
  meshes.right_sleeve = mirrored(meshes.left_sleeve);
  return meshes;
}

// Of the sewn mesh at this spacing.
int count_sewn(double spacing) {
  const Design reference = reference_design();
  const PanelCount front = count_panel(half_outline(Panel::kFront, reference), spacing);
  const PanelCount back = count_panel(half_outline(Panel::kBack, reference), spacing);
  const PanelCount sleeve = count_panel(half_outline(Panel::kLeftSleeve, reference), spacing);
  const int side = front.segments[1], armhole = front.segments[2], shoulder = front.segments[3];
  const int underarm = sleeve.segments[1];
  // A seam of n segments joins n + 1 pairs; its ends: underarm point (5 panel vertices are one: two
  // of each sleeve's side seam ends, front, back) and top of the armhole (3 are one).
  const int merged_a_side = side + (shoulder) + 2 * (armhole - 1) + underarm + 3 + 2;
  return front.vertices + back.vertices + 2 * sleeve.vertices - 2 * merged_a_side;
}

// The spacing (of the reference panels) for about this many sewn vertices.
double find_spacing(int vertex_count) {
  double spacing = std::sqrt(0.8 / (0.87 * vertex_count));  // 0.8 m^2 of equilateral triangles
  double best = spacing;
  int best_error = vertex_count;
  for (int i = 0; i < 12 && best_error > 0; ++i) {
    const int count = count_sewn(spacing);
    if (std::abs(count - vertex_count) < best_error) {
      best_error = std::abs(count - vertex_count);
      best = spacing;
    }
    spacing *= std::sqrt(static_cast<double>(count) / vertex_count);
  }
  return best;
}

const std::vector<int>& vertices_on(const PanelMesh& mesh, Panel panel, Curve curve, int side) {
  const std::vector<Curve> curves = curves_of(panel);
  const auto place = std::find(curves.begin(), curves.end(), curve) - curves.begin();
  return mesh.curves[static_cast<size_t>(place)][side > 0 ? 0 : 1];
}

}  // namespace

GarmentTopology make_topology(int vertex_count) {
  if (vertex_count < 400 || vertex_count > 200000)
    throw InputError("garment.vertex_count = " + std::to_string(vertex_count) +
                     "; expected 400 .. 200000");
  const PanelMeshes meshes = mesh_panels(find_spacing(vertex_count));

  GarmentTopology topology;
  std::array<int, 4> first{};  // panel vertex, of each panel
  int count = 0, face_count = 0;
  for (const Panel panel : kPanels) {
    first[static_cast<size_t>(panel)] = count;
    count += static_cast<int>(meshes.of(panel).points.rows());
    face_count += static_cast<int>(meshes.of(panel).faces.rows());
  }
  topology.uv.resize(count, 2);
  topology.panel_faces.resize(face_count, 3);
  face_count = 0;
  for (const Panel panel : kPanels) {
    const PanelMesh& mesh = meshes.of(panel);
    const int start = first[static_cast<size_t>(panel)];
    topology.uv.middleRows(start, mesh.points.rows()) = reference_to_uv(panel, mesh.points);
    topology.panel_faces.middleRows(face_count, mesh.faces.rows()) = mesh.faces.array() + start;
    topology.panel_of_vertex.insert(topology.panel_of_vertex.end(),
                                    static_cast<size_t>(mesh.points.rows()), panel);
    face_count += static_cast<int>(mesh.faces.rows());
  }

  // Sew: each panel vertex points to the first one of those that it is joined with.
  std::vector<int> joined(static_cast<size_t>(count));
  std::iota(joined.begin(), joined.end(), 0);
  const auto root = [&](int v) {
    while (joined[v] != v) v = joined[v];
    return v;
  };
  const auto sew = [&](Panel a, Curve curve_a, int side_a, Panel b, Curve curve_b, int side_b) {
    const std::vector<int>& of_a = vertices_on(meshes.of(a), a, curve_a, side_a);
    const std::vector<int>& of_b = vertices_on(meshes.of(b), b, curve_b, side_b);
    if (of_a.size() != of_b.size())
      throw std::logic_error("the two sides of a seam differ in their number of points");
    for (size_t i = 0; i < of_a.size(); ++i) {
      const int ra = root(first[static_cast<size_t>(a)] + of_a[i]);
      const int rb = root(first[static_cast<size_t>(b)] + of_b[i]);
      joined[std::max(ra, rb)] = std::min(ra, rb);
    }
  };
  for (const int left : {1, -1}) {  // the wearer's left and right
    const Panel sleeve = left > 0 ? Panel::kLeftSleeve : Panel::kRightSleeve;
    const int on_front = left * left_side(Panel::kFront), on_back = left * left_side(Panel::kBack);
    sew(Panel::kFront, Curve::kSide, on_front, Panel::kBack, Curve::kSide, on_back);
    sew(Panel::kFront, Curve::kShoulder, on_front, Panel::kBack, Curve::kShoulder, on_back);
    sew(sleeve, Curve::kArmhole, front_side(sleeve), Panel::kFront, Curve::kArmhole, on_front);
    sew(sleeve, Curve::kArmhole, -front_side(sleeve), Panel::kBack, Curve::kArmhole, on_back);
    sew(sleeve, Curve::kSide, 1, sleeve, Curve::kSide, -1);
  }
  topology.sewn_vertex.resize(count);
  for (int v = 0; v < count; ++v)
    topology.sewn_vertex[v] =
        root(v) == v ? topology.vertex_count++ : topology.sewn_vertex[root(v)];
  topology.faces = topology.panel_faces.unaryExpr([&](int v) { return topology.sewn_vertex[v]; });
  return topology;
}

Points2 cut_panels(const GarmentTopology& topology, const Design& design) {
  validate(design);
  Points2 panels(topology.uv.rows(), 2);
  const auto& panel_of = topology.panel_of_vertex;
  for (size_t first = 0, end = 0; first < panel_of.size(); first = end) {  // runs of one panel
    while (end < panel_of.size() && panel_of[end] == panel_of[first]) ++end;
    const Eigen::Index start = static_cast<Eigen::Index>(first),
                       count = static_cast<Eigen::Index>(end - first);
    const Panel panel = panel_of[first];
    panels.middleRows(start, count) =
        map_to_design(panel, uv_to_reference(panel, topology.uv.middleRows(start, count)), design);
  }
  return panels;
}

}  // namespace pleat::garment
