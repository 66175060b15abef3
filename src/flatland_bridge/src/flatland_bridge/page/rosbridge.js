// A client of the rosbridge protocol, as small as the page needs it.

export class Rosbridge {
  /** url: of the server; onState(isOpen): called when the connection opens or is lost. */
  constructor(url, onState, onError) {
    this.url = url;
    this.onState = onState;
    this.onError = onError;
    this.receivers = new Map();  // by topic
    this.calls = new Map();  // by id
    this.number = 0;
    this.connect();
  }

  connect() {
    this.socket = new WebSocket(this.url);
    this.socket.onopen = () => this.onState(true);
    this.socket.onclose = () => {
      this.calls.forEach(({reject}) => reject(new Error("the connection is lost")));
      this.calls.clear();
      this.receivers.clear();
      this.onState(false);
      setTimeout(() => this.connect(), 1000);
    };
    this.socket.onmessage = ({data}) => this.receive(JSON.parse(data));
  }

  receive(message) {
    if (message.op === "publish") {
      this.receivers.get(message.topic)?.(message.msg);
    } else if (message.op === "service_response") {
      const call = this.calls.get(message.id);
      this.calls.delete(message.id);
      const values = message.values;
      if (!message.result) call?.reject(new Error(values));
      else if (values.success === false) call?.reject(new Error(values.message));
      else call?.resolve(values);
    } else if (message.op === "status") {
      this.onError(message.msg);
    }
  }

  send(message) {
    if (this.socket.readyState === WebSocket.OPEN) this.socket.send(JSON.stringify(message));
  }

  /** options: throttle_rate [ms], queue_length. */
  subscribe(topic, receive, options = {}) {
    this.receivers.set(topic, receive);
    this.send({op: "subscribe", topic, queue_length: 1, ...options});
  }

  unsubscribe(topic) {
    this.receivers.delete(topic);
    this.send({op: "unsubscribe", topic});
  }

  publish(topic, type, msg) {
    this.send({op: "advertise", topic, type});
    this.send({op: "publish", topic, msg});
  }

  call(service, args = {}) {
    if (this.socket.readyState !== WebSocket.OPEN) return Promise.reject(new Error("the connection is lost"));
    const id = `call:${++this.number}`;
    return new Promise((resolve, reject) => {
      this.calls.set(id, {resolve, reject});
      this.send({op: "call_service", id, service, args});
    });
  }
}
