//! The controllers of the arms, and where the Franka control interface listens.

use std::net::{IpAddr, Ipv4Addr, SocketAddr, TcpListener};

use cell_model::Cell;
use cell_run::spec::Fci;
use supervisor::failure::Failure;

use crate::args::{ControllerArgs, ControllerOf};
use crate::say;

mod holder;

/// TCP ports of the arm and of the hand.
// libfranka has them built in: the interfaces of two arms differ by address.
const PORTS: [u16; 2] = [1337, 1338];

/// Puts the controllers of the command line in place of those of the cell file, and gives by
/// arm its interface.
pub(super) fn controllers_of(
    args: &ControllerArgs,
    cell: &mut Cell,
) -> Result<Vec<Option<Fci>>, Failure> {
    let mut given = vec![None; cell.arms.len()];
    for of in &args.controller {
        let arm = arm_of(of, cell)?;
        cell.arms[arm].controller = Some(of.program.clone());
        given[arm] = of.address;
    }
    let mut next = Ipv4Addr::LOCALHOST;
    let arms = cell.arms.iter().zip(given);
    let interfaces: Vec<Option<Fci>> = arms
        .map(|(arm, given)| {
            let is_fci = arm.has_client();
            let default = IpAddr::V4(next);
            // The n-th interface: 127.0.0.n.
            next = if is_fci {
                Ipv4Addr::from(u32::from(next).wrapping_add(1))
            } else {
                next
            };
            is_fci.then(|| Fci {
                address: given.unwrap_or(default),
                strict: args.strict,
            })
        })
        .collect();
    check(args, cell, &interfaces)?;
    Ok(interfaces)
}

fn arm_of(of: &ControllerOf, cell: &Cell) -> Result<usize, Failure> {
    let names: Vec<&str> = cell.arms.iter().map(|arm| arm.name.as_str()).collect();
    let found = match &of.arm {
        None if names.len() == 1 => Some(0),
        None => None,
        Some(name) => names.iter().position(|known| known == name),
    };
    found.ok_or_else(|| {
        Failure::configuration(match &of.arm {
            Some(name) => format!(
                "--controller {name}={}: no such arm; {}",
                of.program,
                cell_model::suggest::advice(name, &names)
            ),
            None => format!(
                "--controller {}: the cell has {} arms; name one of them, as in --controller {}={}",
                of.program,
                names.len(),
                names.first().unwrap_or(&"ARM"),
                of.program
            ),
        })
    })
}

fn check(args: &ControllerArgs, cell: &Cell, interfaces: &[Option<Fci>]) -> Result<(), Failure> {
    for (arm, fci) in cell.arms.iter().zip(interfaces) {
        let Some(Fci { address, .. }) = fci else {
            continue;
        };
        // Messages of the interface have seven angles.
        if !arm.robot.arm_units().iter().all(|unit| *unit == "rad")
            || arm.robot.arm_joints.len() != 7
        {
            return Err(Failure::configuration(format!(
                "arm '{}': {} has no Franka control interface; `--robot fr3` has one",
                arm.name, arm.robot.name
            )));
        }
        if !address.is_loopback() {
            if !args.fci_from_network {
                return Err(Failure::configuration(format!(
                    "{address} can be reached by other machines, and the Franka control interface \
                     has no password: add --fci-from-network to allow it"
                )));
            }
            say::warn(format_args!(
                "arm '{}' can be commanded by every machine that reaches {address}",
                arm.name
            ));
        }
    }
    Ok(())
}

/// Refuses addresses that another program listens at.
pub(super) fn check_free(interfaces: &[Option<Fci>]) -> Result<(), Failure> {
    for Fci { address, .. } in interfaces.iter().flatten() {
        for port in PORTS {
            if let Err(error) = TcpListener::bind((*address, port)) {
                let at = SocketAddr::new(*address, port);
                let holder = holder::of(at).map_or_else(
                    || "`ss -ltnp` names the program that has the port".to_owned(),
                    |(name, pid)| format!("{name} (process {pid}) has the port"),
                );
                return Err(Failure::configuration(format!(
                    "the Franka control interface cannot listen at {at}: {error}; {holder}, and \
                     `--controller ARM=fci@ADDRESS` chooses another address"
                )));
            }
        }
    }
    Ok(())
}
