"""davarlab: a gyro error model against a recording of the gyro. See DESIGN.md beside this
package."""
