// ODE (ode.org): a step of boxes by its iterative solver (QuickStep), contacts of a step in a joint group, as in its
// demos.
#include <ode/ode.h>

#include <stdexcept>

#include "notes/peers/rigid.h"

namespace lockstep::peers {
namespace {

constexpr int most_contacts = 4;  // of a pair, as ours

class Ode : public Engine {
 public:
  Ode(const Boxes& boxes, int threads) : friction_(boxes.friction), time_step_(boxes.time_step) {
    if (boxes.restitution != 0) throw std::runtime_error("this comparison is for bodies that do not bounce");
    world_ = dWorldCreate();
    space_ = dSweepAndPruneSpaceCreate(nullptr, dSAP_AXES_XZY);
    contacts_ = dJointGroupCreate(0);
    dWorldSetGravity(world_, boxes.gravity.x, boxes.gravity.y, boxes.gravity.z);
    dWorldSetQuickStepNumIterations(world_, boxes.iterations);
    if (threads > 1) {
      threading_ = dThreadingAllocateMultiThreadedImplementation();
      if (!threading_) throw std::runtime_error("this ODE was built without threads");
      pool_ = dThreadingAllocateThreadPool(threads, 0, dAllocateMaskAll, nullptr);
      dThreadingThreadPoolServeMultiThreadedImplementation(pool_, threading_);
      dWorldSetStepThreadingImplementation(world_, dThreadingImplementationGetFunctions(threading_), threading_);
      dWorldSetStepIslandsProcessingMaxThreadCount(world_, threads);
    }
    for (const Ground& ground : boxes.grounds)
      dCreatePlane(space_, ground.normal.x, ground.normal.y, ground.normal.z, ground.offset);
    for (const BoxBody& box : boxes.boxes) add(box);
  }
  ~Ode() override {
    if (threading_) {
      dThreadingImplementationShutdownProcessing(threading_);
      dThreadingFreeThreadPool(pool_);
      dWorldSetStepThreadingImplementation(world_, nullptr, nullptr);
      dThreadingFreeImplementation(threading_);
    }
    dJointGroupDestroy(contacts_);
    dSpaceDestroy(space_);
    dWorldDestroy(world_);
  }

  void step() override {
    dSpaceCollide(space_, this, [](void* self, dGeomID a, dGeomID b) { static_cast<Ode*>(self)->collide(a, b); });
    dWorldQuickStep(world_, time_step_);
    dJointGroupEmpty(contacts_);
  }

  BoxBody box(std::size_t k) const override {
    const auto three = [](const dReal* v) { return Vector3<float>{float(v[0]), float(v[1]), float(v[2])}; };
    BoxBody now{};
    if (!bodies_[k]) return now;
    const dReal* const q = dBodyGetQuaternion(bodies_[k]);
    now.pose.position = three(dBodyGetPosition(bodies_[k]));
    now.pose.orientation = {float(q[1]), float(q[2]), float(q[3]), float(q[0])};
    now.motion.velocity = three(dBodyGetLinearVel(bodies_[k]));
    now.motion.angular_velocity = three(dBodyGetAngularVel(bodies_[k]));
    return now;
  }

 private:
  void add(const BoxBody& box) {
    const auto& [position, q, unused] = box.pose;
    const dQuaternion orientation = {q.w, q.x, q.y, q.z};
    const dGeomID geom = dCreateBox(space_, 2 * box.half.x, 2 * box.half.y, 2 * box.half.z);
    bodies_.push_back(nullptr);
    if (box.mass > 0) {
      const dBodyID body = bodies_.back() = dBodyCreate(world_);
      dMass mass;
      dMassSetBoxTotal(&mass, box.mass, 2 * box.half.x, 2 * box.half.y, 2 * box.half.z);
      dBodySetMass(body, &mass);
      dGeomSetBody(geom, body);
      dBodySetLinearVel(body, box.motion.velocity.x, box.motion.velocity.y, box.motion.velocity.z);
      dBodySetAngularVel(body, box.motion.angular_velocity.x, box.motion.angular_velocity.y,
                         box.motion.angular_velocity.z);
    }
    dGeomSetPosition(geom, position.x, position.y, position.z);
    dGeomSetQuaternion(geom, orientation);
  }

  void collide(dGeomID a, dGeomID b) {
    const dBodyID body_a = dGeomGetBody(a), body_b = dGeomGetBody(b);
    if (!body_a && !body_b) return;
    dContact contact[most_contacts];
    const int count = dCollide(a, b, most_contacts, &contact[0].geom, sizeof(dContact));
    for (int k = 0; k < count; ++k) {
      contact[k].surface.mode = dContactApprox1;
      contact[k].surface.mu = friction_;
      dJointAttach(dJointCreateContact(world_, contacts_, &contact[k]), body_a, body_b);
    }
  }

  dReal friction_, time_step_;
  dWorldID world_;
  dSpaceID space_;
  dJointGroupID contacts_;
  dThreadingImplementationID threading_ = nullptr;
  dThreadingThreadPoolID pool_ = nullptr;
  std::vector<dBodyID> bodies_;  // none of a static box
};

}  // namespace
}  // namespace lockstep::peers

int main(int count, char** words) {
  using namespace lockstep::peers;
  dInitODE2(0);
  dAllocateODEDataForThread(dAllocateMaskAll);
  const int code = report([&](Json& rows) {
    compare_engines(
        rows, asked(count, words),
        [](const Boxes& boxes, int threads) { return std::make_unique<Ode>(boxes, threads); },
        "ODE in double as Debian builds it, ours in float; dt 1/60 s, the scene's friction, at most four points a pair,"
        " nothing sleeps. ODE makes 10 iterations of one step without warm start; ours 8 substeps of two sweeps, warm"
        " started. ODE's collision uses one thread.");
  });
  dCloseODE();
  return code;
}
