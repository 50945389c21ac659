"""Bridges between signals and what controllers speak: OPC UA, Modbus and MQTT, mapped in a file."""
