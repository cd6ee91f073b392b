// The page's words for the engine's names.

const SENSORS: Readonly<Record<string, string>> = {
  baro: "Barometer",
  imu_slave: "Inertial altitude",
  imu_master: "Mother ship's altitude",
  gps: "Reference (GPS)",
};

export function sensorName(sensor: string): string {
  return SENSORS[sensor] ?? sensor;
}

/** A word of the catalogue as text: `level_flight` is "level flight". */
export function plain(word: string): string {
  return word.replaceAll("_", " ");
}

export function capital(text: string): string {
  return text.charAt(0).toUpperCase() + text.slice(1);
}

const SHORT: Readonly<Record<string, string>> = { imu_slave: "Inertial", imu_master: "Mother ship" };

/** A sensor's name where there is little room. */
export function shortSensorName(sensor: string): string {
  return SHORT[sensor] ?? sensorName(sensor);
}

const COLUMNS: Readonly<Record<string, string>> = {
  tas_mps: "airspeed",
  aoa_rad: "angle of attack",
  sideslip_rad: "sideslip",
  throttle: "throttle",
  baro_temp_c: "barometer's temperature",
  oat_c: "outside temperature",
  roll_rad: "roll",
  pitch_rad: "pitch",
  yaw_rad: "heading",
  gps_alt_m: "GPS altitude",
  gps_vd_mps: "GPS descent rate",
  gps_vn_mps: "GPS speed north",
  gps_ve_mps: "GPS speed east",
  gps_sats: "satellites",
  gps_vacc_m: "GPS vertical accuracy",
  baro_alt_m: "barometric altitude",
  baro_pa: "static pressure",
  accel_x_mps2: "acceleration x",
  accel_y_mps2: "acceleration y",
  accel_z_mps2: "acceleration z",
  gyro_x_radps: "turn rate x",
  gyro_y_radps: "turn rate y",
  gyro_z_radps: "turn rate z",
};

export function columnName(column: string): string {
  return COLUMNS[column] ?? plain(column);
}
