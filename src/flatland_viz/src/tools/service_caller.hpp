#pragma once

/// Calls ROS services without blocking the window.

#include <ros/serialization.h>
#include <ros/service_server_link.h>
#include <ros/service_traits.h>

#include <QObject>
#include <QString>
#include <exception>
#include <functional>
#include <mutex>
#include <string>
#include <thread>

namespace flatland_viz {

/// One call at a time runs on a thread of its own. Its response is delivered on the thread that
/// owns this object, which is the window's.
///
/// `ros::ServiceClient` cannot cancel a call: an rviz that is closed would wait for a server that
/// does not answer. So each call has a connection of its own, which can be dropped.
class ServiceCaller : public QObject {
 public:
  /// Receives an error, or an empty string and the response.
  template <class Service>
  using OnAnswer =
      std::function<void(const QString& error, const typename Service::Response& response)>;

  ~ServiceCaller() override { Cancel(); }

  /// Calls the service; cancels a call that has not ended.
  template <class Service>
  void Call(const std::string& name, const typename Service::Request& request,
            OnAnswer<Service> on_answer);

  /// Cancels the present call: its response will not be delivered.
  void Cancel();

  bool is_calling() const { return static_cast<bool>(on_answer_); }

 private:
  using OnSerialized = std::function<void(const QString& error, ros::SerializedMessage& response)>;

  void Start(const std::string& name, const std::string& md5sum, ros::SerializedMessage request,
             OnSerialized on_answer);
  /// On the thread of the call: blocks until there is a response or the connection is dropped.
  QString Exchange(const std::string& name, const std::string& md5sum,
                   const ros::SerializedMessage& request, ros::SerializedMessage& response);
  void Finish(int call, const QString& error, ros::SerializedMessage response);

  OnSerialized on_answer_;  // of the present call; empty if there is none
  int call_ = 0;            // its number
  std::thread thread_;

  std::mutex mutex_;  // guards the members below, which both threads use
  ros::ServiceServerLinkPtr link_;
  bool is_cancelled_ = false;
};

template <class Service>
void ServiceCaller::Call(const std::string& name, const typename Service::Request& request,
                         OnAnswer<Service> on_answer) {
  const auto deserialize = [name, on_answer = std::move(on_answer)](
                               QString error, ros::SerializedMessage& serialized) {
    typename Service::Response response;
    try {
      if (error.isEmpty()) ros::serialization::deserializeMessage(serialized, response);
    } catch (const std::exception& exception) {
      error = QString("The answer of %1 is damaged: %2").arg(name.c_str(), exception.what());
    }
    on_answer(error, response);
  };
  Start(name, ros::service_traits::md5sum<Service>(), ros::serialization::serializeMessage(request),
        deserialize);
}

}  // namespace flatland_viz
