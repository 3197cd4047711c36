// One tessellation's surface at the vertices of another, or at a user's own: the UV layout is the
// same for all.
#pragma once

#include "core/types.h"
#include "garment/template.h"

namespace pleat::garment {

// Places on the panel faces of a tessellation.
struct PanelPlaces {
  Eigen::VectorXi faces;  // #places
  Points3 barycentrics;   // #places x 3, within the face
};

// uv: # x 2, in the layout. Where one lies off every face (coarse outlines cut corners) the nearest
// place of its panel.
PanelPlaces locate(const GarmentTopology& topology, const Eigen::Ref<const Points2>& uv);

// One value a sewn vertex: the mean over its panel vertices, so that both sides of a seam agree.
Points3 sew(const GarmentTopology& topology, const Eigen::Ref<const Points3>& panel_values);

// Values of the sewn vertices of `from`, positions say, at those of `to`: linear on each face.
Points3 resample(const GarmentTopology& from, const Eigen::Ref<const Points3>& values,
                 const GarmentTopology& to);

}  // namespace pleat::garment
