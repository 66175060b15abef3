import sys
import threading

from flatland_server.ros.ros_transport import RosTransport


def test_a_signal_may_end_it_wherever_it_interrupts_it():
    """Python lets signal handlers run where it calls functions: so does a profiler."""
    transport = RosTransport()
    interrupted = set()

    def interrupt(frame, _event, _argument):
        interrupted.add(frame.f_code.co_name)
        transport.end()
        transport.is_ending = False  # there is more to be interrupted

    def simulate():
        sys.setprofile(interrupt)
        transport.process(0.001)
        sys.setprofile(None)

    simulation = threading.Thread(target=simulate, daemon=True)
    simulation.start()
    simulation.join(10)

    assert not simulation.is_alive()
    assert {"process", "wait", "clear", "_is_owned"} <= interrupted


def test_after_its_end_it_waits_for_nothing():
    transport = RosTransport()
    transport.end()

    simulation = threading.Thread(target=transport.process, args=(60.0,), daemon=True)
    simulation.start()
    simulation.join(10)

    assert not simulation.is_alive()
