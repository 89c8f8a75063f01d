// HC-SR04 at an Arduino: distance in cm, 50 times a second, for `collect /dev/ttyACM0 y=cm unit=cm`.
// Trigger on pin 9, echo on pin 10. A missed echo is sent as 0: `data clean` finds it.
const int TRIGGER = 9, ECHO = 10;
const unsigned long STEP = 20000; // [us] between samples
unsigned long due;

void setup() {
  Serial.begin(115200);
  pinMode(TRIGGER, OUTPUT);
  pinMode(ECHO, INPUT);
  due = micros();
}

void loop() {
  while ((long)(micros() - due) < 0) {}
  digitalWrite(TRIGGER, HIGH);
  delayMicroseconds(10);
  digitalWrite(TRIGGER, LOW);
  unsigned long echo = pulseIn(ECHO, HIGH, 15000); // [us] there and back
  Serial.print("ms:"); Serial.print(due / 1000.0, 2);
  Serial.print(",cm:"); Serial.println(echo * 0.01715, 3);
  due += STEP;
}
