# BBC micro:bit, MicroPython: acceleration along y every 20 ms, for `collect /dev/ttyACM0`.
from microbit import accelerometer, running_time, sleep

due = running_time()
while True:
    print("t:%d,y:%d" % (running_time(), accelerometer.get_y()))  # ms; thousandths of g
    due += 20
    sleep(max(0, due - running_time()))
