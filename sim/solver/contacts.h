// What the cloth touches: the body's smooth surface under each vertex, with friction, and barriers
// between features that must not pass through one another.
#pragma once

#include <algorithm>
#include <vector>

#include "sim/body_contact.h"
#include "sim/forces/barrier.h"
#include "sim/forces/contact.h"
#include "sim/forces/friction.h"
#include "sim/solver/near_pairs.h"

namespace pleat::sim {

struct ContactConfig {         // section `contact`
  double distance_m = 0.0035;  // distance from the body's smooth surface at which it begins to push
  double stiffness_N_per_m3 = 3e6;    // spring constant a unit of cloth area
  double stick_N_per_m3 = 4e4;        // spring constant of sticking, a unit of cloth area
  double layer_distance_m = 0.002;    // distance at which layers of cloth begin to push
  double barrier_distance_m = 0.001;  // the same between cloth and the body's mesh
  double barrier_Pa = 500;            // scale of that pressure
};
void validate(const ContactConfig& config);

// The body point that a cloth vertex sticks to; face -1 where it touches nothing.
struct Anchor {
  int face = -1;
  Vec<3> barycentric = Vec<3>::Zero();
};

// Contact with the smooth surface, frozen within a solver iteration.
struct Touching {
  const BodyCollider* body = nullptr;
  std::vector<Contact> contacts;
  std::vector<Friction> frictions;
};

// A barrier at work: its element and its derivatives at the place asked for.
struct ActiveBarrier {
  Barrier element;
  BarrierTerm term;
};

class ContactSearch {
 public:
  // areas: of rest cloth at each vertex, m^2.
  ContactSearch(const Faces& cloth, const Eigen::VectorXd& areas, const Eigen::VectorXd& x,
                const BodyCollider& body, const ContactConfig& config, double friction);

  // The body stands elsewhere now.
  void forget();
  // Looks for loose cloth anew, as if the body had moved on.
  void free_again();
  bool has_loose() const { return has_loose_; }
  // The largest share of the step on which these vertices stay where all that may come near is
  // known, 0 .. 1.
  double known_share(const std::vector<int>& vertices, const Eigen::VectorXd& x,
                     const Eigen::VectorXd& step) const;
  // Finds all that may come near x, and what is loose there, which `prepare` takes as it was.
  void look_around(const Eigen::VectorXd& x);
  // Finds all that may come near on the way from x to x + step, of vertices of which it is not
  // known.
  void prepare(const Eigen::VectorXd& x, const Eigen::VectorXd& step);
  int search_count() const { return search_count_; }

  // How far friction's frozen normal and limit follow those of the moment, at each look: 1 all the
  // way, 0 not at all. The slip from an anchor millimetres below depends so much on the normal that
  // where this turns fast, as in an armpit, iterations that follow it all the way may cycle.
  void follow_friction(double share) { follow_ = share; }

  // What follows holds where all is known.
  Touching touching(const std::vector<int>& vertices, const Eigen::VectorXd& x,
                    std::vector<Anchor>& anchors);
  // Pairs with a vertex whose place is not negative.
  std::vector<int> pairs_at(const std::vector<int>& place) const;
  double barrier_energy(const std::vector<int>& pairs, const Eigen::VectorXd& x) const;
  std::vector<ActiveBarrier> barriers(const std::vector<int>& pairs, const Eigen::VectorXd& x,
                                      Order order) const;
  // How much of the step the cloth may take without passing through anything: 0 .. 1.
  double free_share(const std::vector<int>& pairs, const Eigen::VectorXd& x,
                    const Eigen::VectorXd& step) const;

  // The same where the body runs on to body_next meanwhile; needs nothing to be known. First
  // changes `step` where things would be in the way of one another. is_off_next: body faces that
  // are switched off there.
  double free_share_with_body(const Eigen::VectorXd& x, const Points3& body_next,
                              const std::vector<char>& is_off_next, Eigen::VectorXd& step);
  // The same for the cloth alone; the body may pass through it.
  double free_share_without_body(const Eigen::VectorXd& x, Eigen::VectorXd& step);

  // After a drape: anchors of vertices that slid follow to the slip limit behind them, those that
  // left the body are dropped.
  void settle_anchors(const Eigen::VectorXd& x, std::vector<Anchor>& anchors);

 private:
  int count() const { return static_cast<int>(areas_.size()); }
  // How much farther a vertex may move from x until something may be near of which is not known, m.
  double room_of(int vertex, const Eigen::VectorXd& x) const;
  double range_of(const NearPair& pair) const;
  double largest_range() const {
    return std::max(config_.layer_distance_m, config_.barrier_distance_m);
  }
  PairPoints points_of(const NearPair& pair, const Eigen::VectorXd& x) const;
  Anchor anchor_below(const Vec<3>& place, const Vec<3>& normal) const;
  // The body faces that support a vertex, or the one whose plane a loose vertex is pulled to. They
  // stay the same until it has moved on a little: in a crease, where the nearest of two sides changes with every step, the energy would else be
  // another one each time.
  struct Supports {
    Vec<3> at = Vec<3>::Zero();  // m, where the vertex stood when they were found
    std::vector<Contact> contacts;
    int leader = 0;                  // whose tangent plane friction acts in
    Vec<3> normal = Vec<3>::Zero();  // of friction, as it was last; 0: there was none
    double limit = 0;                // the same, N
    // How far the vertex moves until they are found anew, m, and how many times as hard the other
    // must push to become the leader. Twice as much each time that they come back to what they
    // were, and that the leader changes: else they might for ever.
    double still = 0.002, stronger = 2;
    int before = -1;  // the first face, before it was what it is

    int face() const { return contacts.empty() ? -1 : contacts[0].body_face; }
    void begin_at(const Vec<3>& x);  // with none yet
    void note_change_from(int face);
  };
  void find_supports(int vertex, const Vec<3>& x, Supports& found) const;
  void find_pull(int vertex, const Vec<3>& x, Supports& found) const;  // of a loose one
  void add_contacts(int vertex, const Vec<3>& x, Anchor& anchor, Touching& touching);
  void find_loose(const Eigen::VectorXd& x);
  size_t learn(const PairFinder::Found& fresh, const std::vector<char>& is_asked);
  void measure(const Eigen::VectorXd& x, size_t old);
  Scene scene_at(const Eigen::VectorXd& x) const;
  double make_way(const Scene& still, const Points3& body_motion, Eigen::VectorXd& step);
  template <typename Action>
  void for_each_barrier(const std::vector<int>& pairs, const Eigen::VectorXd& x,
                        Action action) const;

  const BodyCollider& body_;
  ContactConfig config_;
  double friction_;
  Eigen::VectorXd areas_;
  double mean_area_;
  PairFinder finder_;
  SurfaceTree cloth_tree_;
  bool may_cross_ = true;  // something was allowed through since loose vertices were looked for
  // Vertices inside the body, or on cloth that crosses it, where the body is not switched off: they
  // came there while it was. Nothing holds them off the body until springs have pulled them out.
  bool has_loose_ = false;
  std::vector<char> is_loose_;
  std::vector<Supports> supports_;  // of each vertex
  Eigen::VectorXd loose_at_;        // where they were looked for
  double follow_ = 1;
  bool is_known_ = false;
  int search_count_ = 0;
  PairFinder::Found found_;
  Eigen::VectorXd found_at_, reach_;
  Eigen::VectorXd measured_at_;  // where the pairs' distances are bounds from below
};

}  // namespace pleat::sim
