/// rviz's display of the models' names and headings.

#include <OgrePrerequisites.h>
#include <OgreSceneNode.h>
#include <OgreViewport.h>
#include <ros/time.h>
#include <rviz/display.h>
#include <rviz/display_context.h>
#include <rviz/display_group.h>
#include <rviz/frame_manager.h>
#include <rviz/properties/bool_property.h>
#include <rviz/properties/color_property.h>

#include <QColor>
#include <QRectF>
#include <QStringList>
#include <memory>
#include <pluginlib/class_list_macros.hpp>

#include "before_render.hpp"
#include "ground_truth_frames.hpp"
#include "model_marks.hpp"
#include "window_property.hpp"
#include "world_models.hpp"
#include "world_plane.hpp"

namespace flatland_viz {
namespace {

const ros::WallDuration kBoundsPeriod(0.2);

}  // namespace

/// Names the models, shows where robots look, and places robots by their ground truth where there
/// is no localiser.
class ModelsDisplay : public rviz::Display {
 public:
  ModelsDisplay();
  ~ModelsDisplay() override;

  void update(float wall_dt, float ros_dt) override;
  void reset() override;

 protected:
  void onInitialize() override;
  void onEnable() override;
  void onDisable() override;

 private:
  void PlaceFrames();
  void PlaceMarks(const Ogre::Viewport& viewport, double pixel_ratio);
  void ListColors();
  void FollowBounds();
  QColor Background() const;

  rviz::BoolProperty* labels_;
  rviz::BoolProperty* headings_;
  rviz::BoolProperty* places_frames_;
  rviz::Property* colors_;         // of the robots, "#rrggbb" by name
  rviz::Property* bounds_;         // around all models [m]; null while some are not placed
  rviz::Property* placed_frames_;  // by ground truth, with commas between them

  std::shared_ptr<WorldModels> models_;
  std::unique_ptr<GroundTruthFrames> frames_;
  std::unique_ptr<ModelMarks> marks_;
  std::unique_ptr<BeforeRender> before_render_;
  unsigned drawn_revision_ = 0;  // of the models
  unsigned bounds_revision_ = 0;
  ros::WallTime bounds_at_;
};

ModelsDisplay::ModelsDisplay()
    : labels_(new rviz::BoolProperty("Labels", true, "The names of the models.", this,
                                     SLOT(queueRender()))),
      headings_(new rviz::BoolProperty("Headings", true, "Where robots look.", this,
                                       SLOT(queueRender()))),
      places_frames_(new rviz::BoolProperty(
          "Ground Truth", true,
          "While nothing publishes a transform from the map to a robot's odometry frame, place the "
          "robot's frames by its true pose.",
          this)),
      colors_(WindowProperty("Colors", this, QVariantMap())),
      bounds_(WindowProperty("Bounds", this, QRectF())),
      placed_frames_(WindowProperty("Placed Frames", this)) {}

ModelsDisplay::~ModelsDisplay() = default;

void ModelsDisplay::onInitialize() {
  models_ = WorldModels::Of(*context_);
  frames_ = std::make_unique<GroundTruthFrames>(context_->getFrameManager()->getTF2BufferPtr(),
                                                *models_, update_nh_);
  connect(models_.get(), &WorldModels::Moved, this,
          [this](const flatland_msgs::ModelStates& states) { frames_->Add(states); });
  marks_ = std::make_unique<ModelMarks>(*scene_manager_, *scene_node_);
  before_render_ = std::make_unique<BeforeRender>(
      *context_, [this](const auto&... view) { PlaceMarks(view...); });
  connect(models_.get(), &WorldModels::Listed, this, &ModelsDisplay::ListColors);
  connect(models_.get(), &WorldModels::Listed, this, [this] { bounds_->setValue(QRectF()); });
  ListColors();
}

void ModelsDisplay::reset() {
  rviz::Display::reset();
  frames_->Clear();
}

void ModelsDisplay::onEnable() { scene_node_->setVisible(true); }

void ModelsDisplay::onDisable() { scene_node_->setVisible(false); }

void ModelsDisplay::update(float /*wall_dt*/, float /*ros_dt*/) {
  PlaceFrames();
  FollowBounds();
  if (models_->revision() != drawn_revision_) queueRender();
  drawn_revision_ = models_->revision();
}

void ModelsDisplay::PlaceMarks(const Ogre::Viewport& viewport, double pixel_ratio) {
  const auto world = WorldPlane::Find(*context_);
  if (!world || !isEnabled()) return;
  ModelMarks::Options options;
  options.labels = labels_->getBool();
  options.headings = headings_->getBool();
  options.background = Background();
  options.pixel_ratio = pixel_ratio;
  marks_->Update(*models_, *world, viewport, options);
}

QColor ModelsDisplay::Background() const {
  rviz::Property* options = context_->getRootDisplayGroup()->subProp("Global Options");
  const auto* color = dynamic_cast<rviz::ColorProperty*>(options->subProp("Background Color"));
  return color ? color->getColor() : Qt::white;
}

void ModelsDisplay::ListColors() {
  QVariantMap colors;
  for (const auto& [name, model] : models_->models()) {
    if (model.is_robot()) colors[QString::fromStdString(name)] = model.color().name();
  }
  colors_->setValue(colors);
}

void ModelsDisplay::FollowBounds() {
  const ros::WallTime now = ros::WallTime::now();
  const bool is_due = bounds_->getValue().toRectF().isNull() || now - bounds_at_ >= kBoundsPeriod;
  if (!is_due || models_->revision() == bounds_revision_) return;
  bounds_at_ = now;
  bounds_revision_ = models_->revision();
  QRectF bounds;
  for (const auto& [name, model] : models_->models()) {
    if (!model.is_placed()) return;
    const double radius = model.radius();
    const QPointF middle = model.middle_in_world();
    bounds |= QRectF(middle.x() - radius, middle.y() - radius, 2 * radius, 2 * radius);
  }
  bounds_->setValue(bounds);
}

void ModelsDisplay::PlaceFrames() {
  QStringList placed;
  if (places_frames_->getBool()) {
    frames_->Update();
    for (const std::string& root : frames_->roots()) placed << QString::fromStdString(root);
  }
  placed_frames_->setValue(placed.join(", "));
}

}  // namespace flatland_viz

PLUGINLIB_EXPORT_CLASS(flatland_viz::ModelsDisplay, rviz::Display)
