// Bullet (bulletphysics.org): a step of boxes, as in its own examples of stacks: box shapes, a dynamic tree as broad
// phase, sequential impulses warm started, split impulse. On one thread: Debian builds it without others.
#include <btBulletDynamicsCommon.h>

#include <cmath>

#include "notes/peers/rigid.h"

namespace lockstep::peers {
namespace {

btVector3 vector(const auto& v) { return btVector3(btScalar(v.x), btScalar(v.y), btScalar(v.z)); }
Vector3<float> vector3(const btVector3& v) { return {float(v.x()), float(v.y()), float(v.z())}; }

class Bullet : public Engine {
 public:
  explicit Bullet(const Boxes& boxes) : time_step_(btScalar(boxes.time_step)) {
    configuration_ = std::make_unique<btDefaultCollisionConfiguration>();
    broad_phase_ = std::make_unique<btDbvtBroadphase>();
    dispatcher_ = std::make_unique<btCollisionDispatcher>(configuration_.get());
    solver_ = std::make_unique<btSequentialImpulseConstraintSolver>();
    world_ = std::make_unique<btDiscreteDynamicsWorld>(dispatcher_.get(), broad_phase_.get(), solver_.get(),
                                                       configuration_.get());
    world_->setGravity(vector(boxes.gravity));
    world_->getSolverInfo().m_numIterations = boxes.iterations;
    for (const Ground& ground : boxes.grounds)
      add(std::make_unique<btStaticPlaneShape>(vector(ground.normal), ground.offset), 0, btTransform::getIdentity(),
          boxes);
    first_box_ = bodies_.size();
    for (const BoxBody& box : boxes.boxes) {
      const auto& [x, y, z, w] = box.pose.orientation;
      add(std::make_unique<btBoxShape>(vector(box.half)), box.mass,
          btTransform(btQuaternion(x, y, z, w), vector(box.pose.position)), boxes);
      bodies_.back()->setLinearVelocity(vector(box.motion.velocity));
      bodies_.back()->setAngularVelocity(vector(box.motion.angular_velocity));
    }
  }
  ~Bullet() override {
    for (const auto& body : bodies_) world_->removeRigidBody(body.get());
  }

  void step() override { world_->stepSimulation(time_step_, 0); }

  BoxBody box(std::size_t k) const override {
    const btRigidBody& body = *bodies_[first_box_ + k];
    const btTransform& at = body.getWorldTransform();
    const btQuaternion q = at.getRotation();
    BoxBody now{};
    now.pose.position = vector3(at.getOrigin());
    now.pose.orientation = {float(q.x()), float(q.y()), float(q.z()), float(q.w())};
    now.motion.velocity = vector3(body.getLinearVelocity());
    now.motion.angular_velocity = vector3(body.getAngularVelocity());
    return now;
  }

 private:
  void add(std::unique_ptr<btCollisionShape> shape, float mass, const btTransform& at, const Boxes& boxes) {
    btVector3 inertia(0, 0, 0);
    if (mass > 0) shape->calculateLocalInertia(mass, inertia);
    btRigidBody::btRigidBodyConstructionInfo info(mass, nullptr, shape.get(), inertia);
    info.m_startWorldTransform = at;
    info.m_friction = std::sqrt(boxes.friction);  // of a contact: the product of both
    info.m_restitution = std::sqrt(boxes.restitution);
    shapes_.push_back(std::move(shape));
    bodies_.push_back(std::make_unique<btRigidBody>(info));
    bodies_.back()->setActivationState(DISABLE_DEACTIVATION);
    world_->addRigidBody(bodies_.back().get());
  }

  btScalar time_step_;
  std::unique_ptr<btCollisionConfiguration> configuration_;
  std::unique_ptr<btBroadphaseInterface> broad_phase_;
  std::unique_ptr<btCollisionDispatcher> dispatcher_;
  std::unique_ptr<btSequentialImpulseConstraintSolver> solver_;
  std::unique_ptr<btDiscreteDynamicsWorld> world_;
  std::vector<std::unique_ptr<btCollisionShape>> shapes_;
  std::vector<std::unique_ptr<btRigidBody>> bodies_;
  std::size_t first_box_ = 0;
};

}  // namespace
}  // namespace lockstep::peers

int main(int count, char** words) {
  using namespace lockstep::peers;
  return report([&](Json& rows) {
    compare_engines(
        rows, asked(count, words),
        [](const Boxes& boxes, int) { return std::make_unique<Bullet>(boxes); },
        "Both in float, dt 1/60 s, friction as the scene has it, nothing sleeps. Bullet makes 10 iterations of one step"
        " with contacts found once; ours 8 substeps of two sweeps. Bullet adds points to a manifold over steps, ours"
        " finds all of them anew.");
  });
}
