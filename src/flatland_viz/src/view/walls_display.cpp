/// An rviz display for walls: millions of lines that hardly ever change.

#include <OgreMaterial.h>
#include <OgreViewport.h>
#include <flatland_msgs/Walls.h>
#include <rviz/render_panel.h>
#include <rviz/view_manager.h>

#include <QRectF>
#include <algorithm>
#include <cmath>
#include <memory>
#include <mutex>
#include <optional>
#include <pluginlib/class_list_macros.hpp>
#include <string>
#include <utility>
#include <vector>

#include "../tools/window_property.hpp"
#include "topic_display.hpp"
#include "wall_fill.hpp"
#include "wall_lines.hpp"

namespace flatland_viz {
namespace {

constexpr std::size_t kNumbers = 4;                 // x1, y1, x2, y2 of a segment
constexpr std::size_t kSegmentsPerBuffer = 8192;    // Neighbours in the list are neighbours on the
                                                    // map: buffers out of sight are left out.
constexpr std::size_t kFillPerBuffer = 12 * 4096;   // numbers: 12 of a trapezoid
constexpr std::size_t kMostFilled = 4000000;        // numbers of a layer that is filled
constexpr std::size_t kSegmentsPerUpdate = 500000;  // takes some 30 ms
constexpr float kWidth = 0.05f;                     // m: of lines; those of filled walls are thin
constexpr float kLongLine = 1.5f;                   // times the shortest line
constexpr float kContrast = 0.4f;        // difference of brightness; walls with less are changed
constexpr float kWantedContrast = 0.5f;  // difference after the change
constexpr float kMostContrast = 0.6f;    // on a dark background, where white walls would dazzle

/// The bounding box of all walls; null if there are none.
QRectF BoundsOf(const flatland_msgs::Walls& walls) {
  float low[2] = {INFINITY, INFINITY}, high[2] = {-INFINITY, -INFINITY};
  for (const flatland_msgs::LayerWalls& layer : walls.layers) {
    for (std::size_t i = 0; i < layer.segments.size(); ++i) {
      low[i % 2] = std::min(low[i % 2], layer.segments[i]);
      high[i % 2] = std::max(high[i % 2], layer.segments[i]);
    }
  }
  if (!(low[0] <= high[0])) return QRectF();
  return QRectF(low[0], low[1], high[0] - low[0], high[1] - low[1]);
}

/// The outlines of filled walls that are drawn, so that thin walls are visible from afar: lines
/// longer than the steps of single pixels, of which maps have thousands.
std::vector<float> LongLinesOf(const std::vector<float>& segments) {
  std::vector<float> lengths, lines;
  for (std::size_t i = 0; i + kNumbers <= segments.size(); i += kNumbers) {
    const float* ends = &segments[i];
    lengths.push_back(std::hypot(ends[2] - ends[0], ends[3] - ends[1]));
  }
  const auto step = std::min_element(lengths.begin(), lengths.end());
  for (std::size_t i = 0; i < lengths.size(); ++i) {
    const float* ends = &segments[kNumbers * i];
    if (lengths[i] > kLongLine * *step) lines.insert(lines.end(), ends, ends + kNumbers);
  }
  return lines;
}

/// The perceived brightness of a colour: 0 to 1 (luma, ITU-R BT.601).
float Luma(const Ogre::ColourValue& color) {
  return 0.299f * color.r + 0.587f * color.g + 0.114f * color.b;
}

/// A colour that can be seen on a background and does not dazzle: as it is, or mixed with white or
/// black.
Ogre::ColourValue ColorOn(const Ogre::ColourValue& background, const Ogre::ColourValue& color) {
  const float ground = Luma(background), luma = Luma(color);
  const bool is_dark = ground < 0.5f, dazzles = is_dark && luma > ground + kMostContrast;
  if (std::abs(luma - ground) >= kContrast && !dazzles) return color;
  const Ogre::ColourValue other =
      is_dark && !dazzles ? Ogre::ColourValue::White : Ogre::ColourValue::Black;
  const float contrast = dazzles ? kMostContrast : kWantedContrast;
  const float wanted = is_dark ? ground + contrast : ground - contrast;
  const float share = (wanted - luma) / (Luma(other) - luma);
  Ogre::ColourValue mixed = color * (1.0f - share) + other * share;
  mixed.a = color.a;
  return mixed;
}

}  // namespace

/// Shows the walls of all layers, from a topic with flatland_msgs/Walls.
///
/// A line is 5 cm wide, but at least a pixel, so that it is visible from afar. The outlines of a
/// map image are filled. Messages are received on rviz's second thread, and put into buffers in
/// portions: the view stays usable meanwhile.
///
/// Walls stay when simulated time goes back, as they do not depend on it.
class WallsDisplay : public TopicDisplay {
 public:
  WallsDisplay();
  ~WallsDisplay() override;

  void update(float wall_dt, float ros_dt) override;

 protected:
  ros::Subscriber Subscribe(const std::string& topic) override;
  void Clear() override;

 private:
  /// The walls of a layer that are shown.
  struct Layer;

  void Receive(const flatland_msgs::Walls::ConstPtr& message);
  void BeginShowing();
  void ShowMore();

  rviz::Property* progress_;  // percent of the walls that are shown
  rviz::Property* bounds_;    // of the walls [m]; null without walls
  std::mutex mutex_;
  /// A message, and for each of its layers the corners of triangles within its outlines, and the
  /// ends of those lines that are drawn; none: all.
  struct Filled {
    flatland_msgs::Walls::ConstPtr walls;
    std::vector<std::vector<float>> fills, lines;
  };
  std::optional<Filled> received_;  // guarded by mutex_
  std::optional<Filled> showing_;   // until all of it is in layers_
  std::size_t next_layer_ = 0;      // of showing_
  std::size_t next_number_ = 0;     // of that layer's lines
  std::string frame_;               // of the walls
  std::vector<std::unique_ptr<Layer>> layers_;
};

struct WallsDisplay::Layer : LineGroup {
  using LineGroup::LineGroup;

  float width = kWidth;  // m
};

WallsDisplay::WallsDisplay()
    : TopicDisplay(ros::message_traits::datatype<flatland_msgs::Walls>(),
                   "A topic with the walls of all layers."),
      progress_(WindowProperty("Progress", this, 100)),
      bounds_(WindowProperty("Bounds", this, QRectF())) {}

WallsDisplay::~WallsDisplay() { subscriber_.shutdown(); }

ros::Subscriber WallsDisplay::Subscribe(const std::string& topic) {
  return threaded_nh_.subscribe(topic, 1, &WallsDisplay::Receive, this);
}

void WallsDisplay::Clear() {
  std::lock_guard<std::mutex> lock(mutex_);
  received_.reset();
  showing_.reset();
  layers_.clear();
}

/// On rviz's second thread.
void WallsDisplay::Receive(const flatland_msgs::Walls::ConstPtr& message) {
  Filled filled{message, {}, {}};
  for (const flatland_msgs::LayerWalls& layer : message->layers) {
    const bool is_filled = layer.encloses && layer.segments.size() <= kMostFilled;
    filled.fills.push_back(is_filled ? FillOf(layer.segments) : std::vector<float>());
    const bool has_fill = !filled.fills.back().empty();
    filled.lines.push_back(has_fill ? LongLinesOf(layer.segments) : std::vector<float>());
  }
  std::lock_guard<std::mutex> lock(mutex_);
  received_ = std::move(filled);
}

void WallsDisplay::update(float, float) {
  bool is_new;
  {
    std::lock_guard<std::mutex> lock(mutex_);
    is_new = received_.has_value();
    if (is_new) showing_ = std::exchange(received_, std::nullopt);
  }
  if (is_new) BeginShowing();
  if (showing_) ShowMore();
  if (layers_.empty()) return;
  Place(frame_);
  const rviz::RenderPanel& panel = *context_->getViewManager()->getRenderPanel();
  const Ogre::ColourValue background = panel.getViewport()->getBackgroundColour();
  for (const auto& layer : layers_) {
    SetLineWidth(*layer->material, LineWidth(panel, layer->width));
    SetLineColor(*layer->material, ColorOn(background, layer->color));
  }
}

void WallsDisplay::BeginShowing() {
  layers_.clear();
  const flatland_msgs::Walls::ConstPtr& message = showing_->walls;
  next_layer_ = next_number_ = 0;
  frame_ = message->header.frame_id;
  for (const flatland_msgs::LayerWalls& walls : message->layers) {
    layers_.push_back(std::make_unique<Layer>(walls.color, *getSceneNode()));
    Layer& layer = *layers_.back();
    const std::vector<float>& fill = showing_->fills[layers_.size() - 1];
    if (!fill.empty()) layer.width = 0.0f;
    for (std::size_t i = 0; i < fill.size(); i += kFillPerBuffer) {
      const std::size_t count = std::min(fill.size() - i, kFillPerBuffer) / 2;
      layer.Add(&fill[i], count, Ogre::RenderOperation::OT_TRIANGLE_LIST);
    }
  }
  bounds_->setValue(BoundsOf(*message));
}

/// Puts the next portion of the message into buffers.
void WallsDisplay::ShowMore() {
  std::size_t budget = kSegmentsPerUpdate;
  for (; next_layer_ < showing_->walls->layers.size(); ++next_layer_, next_number_ = 0) {
    const std::vector<float>& chosen = showing_->lines[next_layer_];
    const std::vector<float>& lines =
        chosen.empty() ? showing_->walls->layers[next_layer_].segments : chosen;
    Layer& layer = *layers_[next_layer_];
    const std::size_t numbers = lines.size() / kNumbers * kNumbers;
    while (next_number_ < numbers) {
      if (budget == 0) {
        progress_->setValue(static_cast<int>(100 * next_number_ / numbers));
        return;
      }
      const std::size_t count = std::min(numbers - next_number_, kNumbers * kSegmentsPerBuffer);
      layer.Add(&lines[next_number_], count / 2, Ogre::RenderOperation::OT_LINE_LIST);
      next_number_ += count;
      budget -= std::min(budget, count / kNumbers);
    }
  }
  showing_.reset();
  progress_->setValue(100);
}

}  // namespace flatland_viz

PLUGINLIB_EXPORT_CLASS(flatland_viz::WallsDisplay, rviz::Display)
