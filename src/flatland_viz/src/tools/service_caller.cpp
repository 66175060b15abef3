#include "service_caller.hpp"

#include <ros/connection.h>
#include <ros/names.h>
#include <ros/service_manager.h>

#include <QMetaObject>
#include <utility>

namespace flatland_viz {

void ServiceCaller::Start(const std::string& name, const std::string& md5sum,
                          ros::SerializedMessage request, OnSerialized on_answer) {
  Cancel();
  is_cancelled_ = false;
  on_answer_ = std::move(on_answer);
  const int call = ++call_;
  thread_ = std::thread([this, call, name = ros::names::resolve(name), md5sum, request] {
    ros::SerializedMessage response;
    const QString error = Exchange(name, md5sum, request, response);
    QMetaObject::invokeMethod(
        this, [this, call, error, response] { Finish(call, error, response); },
        Qt::QueuedConnection);
  });
}

QString ServiceCaller::Exchange(const std::string& name, const std::string& md5sum,
                                const ros::SerializedMessage& request,
                                ros::SerializedMessage& response) {
  const auto link =
      ros::ServiceManager::instance()->createServiceServerLink(name, false, md5sum, md5sum, {});
  if (!link) {
    return QString("There is no service %1. Is flatland_server running?").arg(name.c_str());
  }
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    if (is_cancelled_) {
      link->getConnection()->drop(ros::Connection::Destructing);
      return "Cancelled.";
    }
    link_ = link;
  }
  const bool is_answered = link->call(request, response);
  const std::lock_guard<std::mutex> lock(mutex_);
  link_.reset();
  if (is_answered) return {};
  return QString("%1 gave no answer. flatland_server has ended, or its output says why.")
      .arg(name.c_str());
}

void ServiceCaller::Finish(int call, const QString& error, ros::SerializedMessage response) {
  if (call != call_ || !on_answer_) return;  // cancelled after its thread had ended
  thread_.join();
  // The function may start the next call.
  const OnSerialized on_answer = std::exchange(on_answer_, nullptr);
  on_answer(error, response);
}

void ServiceCaller::Cancel() {
  on_answer_ = nullptr;
  if (!thread_.joinable()) return;
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    is_cancelled_ = true;
    if (link_) link_->getConnection()->drop(ros::Connection::Destructing);
  }
  thread_.join();
}

}  // namespace flatland_viz
